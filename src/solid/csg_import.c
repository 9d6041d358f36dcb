// SPDX-License-Identifier: MIT
/* import("model.stl") of .csg files: polygon models, and level sets of .vdb and .nvdb files. A path
 * is relative to the file that names it. */
#include <qn/mesh.h>
#include <qn/volume.h>

#include <string.h>
#include <strings.h>
#include <sys/stat.h>

#include "solid/csg_build.h"

enum { LONGEST_PATH = 4096 };

static bool ends_with(const char *name, const char *ending) {
    size_t length = strlen(name), tail = strlen(ending);
    return length >= tail && strcasecmp(name + length - tail, ending) == 0;
}

/* The text of the argument with its escapes undone, behind the folder of the file that is read. */
static qn_status find_path(const qni_csg_builder *build, const qni_csg_call *call,
                           char path[LONGEST_PATH]) {
    const qni_csg_value *value = qni_csg_find(call, "file");
    if (!value && call->arguments && call->arguments->name.length == 0)
        value = &call->arguments->value;
    if (!value || value->kind != QNI_CSG_STRING || value->text.length == 0)
        return qni_csg_fail(build, call, QN_ERROR_INPUT, "expected the name of a file");
    const char *slash = strrchr(build->text->name, '/');
    int64_t folder = slash && value->text.at[0] != '/' ? slash + 1 - build->text->name : 0;
    if (folder + value->text.length >= LONGEST_PATH)
        return qni_csg_fail(build, call, QN_ERROR_INPUT, "the name of the file is too long");
    memcpy(path, build->text->name, (size_t)folder);
    int64_t used = folder;
    for (int64_t n = 0; n < value->text.length; ++n) {
        bool escape = value->text.at[n] == '\\' && n + 1 < value->text.length;
        path[used++] = value->text.at[n += escape];
    }
    path[used] = '\0';
    if (strlen(path) != (size_t)used)
        return qni_csg_fail(build, call, QN_ERROR_INPUT, "the name of the file has a 0 in it");
    struct stat about;
    if (stat(path, &about) != 0 || !S_ISREG(about.st_mode))
        return qni_csg_fail(build, call, QN_ERROR_INPUT, "'%.200s' is no file", path);
    return QN_OK;
}

static qn_status import_mesh(qni_csg_builder *build, const char *path, qn_solid **solid_out) {
    qn_mesh *mesh;
    QN_TRY(qn_mesh_read(build->context, path, NULL, &mesh, build->error));
    qn_solid_mesh_options options;
    qn_solid_mesh_options_init(&options);
    options.owner = ++build->owner;
    options.one_owner = true;
    qn_solid_mesh_report report;
    qn_status status =
        qn_solid_from_mesh(build->context, mesh, &options, solid_out, &report, build->error);
    qn_mesh_destroy(mesh);
    if (status == QN_OK && !report.closed)
        qni_log(build->context, QN_LOG_WARNING,
                "'%.200s' is not closed: its %lld holes are closed over", path,
                (long long)report.holes);
    return status;
}

static qn_status import_volume(qni_csg_builder *build, const char *path, qn_solid **solid_out) {
    qn_volume *volume;
    QN_TRY(qn_volume_read(build->context, path, NULL, &volume, build->error));
    qn_solid_volume_options options;
    qn_solid_volume_options_init(&options);
    options.owner = ++build->owner;
    qn_solid *solid;
    qn_status status = qn_solid_from_volume(build->context, volume, 0, QN_INSIDE_BELOW, &options,
                                            &solid, build->error);
    if (status != QN_OK) {
        qn_volume_destroy(volume);
        return status;
    }
    qn_solid *kept = qni_keeper_create(build->context, solid, volume);
    qn_solid_destroy(solid);
    if (!kept)
        qn_volume_destroy(volume);
    return qni_csg_give(build, kept, solid_out);
}

qn_status qni_csg_import(qni_csg_builder *build, const qni_csg_call *call, qn_solid **solid_out) {
    static const char *const meshes[] = {".stl", ".obj", ".ply", ".off", ".glb", ".gltf"};
    char path[LONGEST_PATH], plain[LONGEST_PATH];
    QN_TRY(find_path(build, call, path));
    memcpy(plain, path, sizeof plain);
    if (ends_with(plain, ".gz"))
        plain[strlen(plain) - 3] = '\0';
    for (size_t n = 0; n < sizeof meshes / sizeof *meshes; ++n)
        if (ends_with(plain, meshes[n]))
            return import_mesh(build, path, solid_out);
    if (ends_with(path, ".vdb") || ends_with(path, ".nvdb"))
        return import_volume(build, path, solid_out);
    return qni_csg_fail(
        build, call, QN_ERROR_UNSUPPORTED,
        "'%.200s' cannot be imported; .stl, .obj, .ply, .off, .glb, .gltf, .vdb and "
        ".nvdb files can",
        path);
}
