// SPDX-License-Identifier: MIT
/* A measurement in a process of its own, so that its peak memory can be seen and nothing that ran
 * before it warms or fills anything: clocks, and an outcome sent back through a pipe. */
#ifndef BENCH_APART_H
#define BENCH_APART_H

#include <qn/qn.h>

extern "C" {
#include "bench/measure.h"
}

#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>

namespace apart {

inline void must(qn_status status, const qn_error &error) {
    if (status == QN_OK)
        return;
    std::fprintf(stderr, "%s\n", error.message);
    std::exit(1);
}

/* Time and memory of a stretch of work: resident memory beyond what was there when it began. */
class stretch {
  public:
    stretch() : before_(bench_resident()) {
        bench_reset_peak_resident();
        start_ = bench_now();
    }
    bench_time time() const {
        return bench_since(start_);
    }
    double megabytes() const {
        return static_cast<double>(std::max<int64_t>(bench_peak_resident() - before_, 0)) / 1048576;
    }

  private:
    int64_t before_;
    bench_time start_;
};

/* What `work` returns, run in a child; false when the child broke. Outcomes are plain data. */
template <class outcome, class function> bool measure(const function &work, outcome *result) {
    int ends[2];
    if (pipe(ends) != 0)
        return false;
    std::fflush(nullptr);
    const pid_t child = fork();
    if (child == 0) {
        const outcome here = work();
        const bool sent = write(ends[1], &here, sizeof here) == static_cast<ssize_t>(sizeof here);
        _exit(sent ? 0 : 1);
    }
    close(ends[1]);
    const bool got =
        child > 0 && read(ends[0], result, sizeof *result) == static_cast<ssize_t>(sizeof *result);
    close(ends[0]);
    int status = 0;
    if (child > 0)
        waitpid(child, &status, 0);
    return got && status == 0;
}

} // namespace apart

#endif
