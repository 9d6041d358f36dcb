// SPDX-License-Identifier: MIT
/* "Did you mean": the word of a list that is closest to a mistyped one. */
#ifndef CLI_NEAREST_H
#define CLI_NEAREST_H

/* NULL when none is within two edits (one, for words of up to four letters). */
const char *nearest_word(const char *word, const char *const *words, int count);

#endif
