/* Text for the harnesses: words that mean something, put where they do not belong. */
#ifndef FURROW_TESTS_FUZZ_TEXT_INPUT_H
#define FURROW_TESTS_FUZZ_TEXT_INPUT_H

#include <string.h>

#include "fuzz.h"

/* A word over what is at a random place, or in between. */
static inline size_t text_put_word(fw_random *r, uint8_t *data, size_t size, size_t max, const char *word)
{
	const size_t n = strlen(word), at = (size_t)fw_random_below(r, size + 1);
	if (n > max - size)
		return size;
	if (fw_random_below(r, 2) == 0 && n <= size - at) {
		memcpy(data + at, word, n);
		return size;
	}
	memmove(data + at + n, data + at, size - at);
	memcpy(data + at, word, n);
	return size + n;
}

/* Some byte of the input that is `what`: to spoil fields and lines. `size` when there is none. */
static inline size_t text_find(fw_random *r, const uint8_t *data, size_t size, int what)
{
	const size_t from = (size_t)fw_random_below(r, size + 1);
	const uint8_t *p = memchr(data + from, what, size - from);
	if (p == NULL)
		p = memchr(data, what, from);
	return p != NULL ? (size_t)(p - data) : size;
}

/* A field or line, the stretch between two separators, goes or comes twice. */
static inline size_t text_spoil_order(fw_random *r, uint8_t *data, size_t size, size_t max, int separator)
{
	const size_t at = text_find(r, data, size, separator);
	const uint8_t *next = at < size ? memchr(data + at + 1, separator, size - at - 1) : NULL;
	const size_t n = next != NULL ? (size_t)(next - (data + at)) : 0;
	if (n == 0)
		return size;
	if (fw_random_below(r, 2) == 0) {
		memmove(data + at, data + at + n, size - at - n);
		return size - n;
	}
	if (n > max - size)
		return size;
	memmove(data + at + n, data + at, size - at);
	return size + n;
}

/* What LLVMFuzzerCustomMutator() does with text of n words. */
static inline size_t text_mutate(uint8_t *data, size_t size, size_t max, unsigned seed,
                                 const char *const *words, size_t n)
{
	fw_random r;
	fw_random_init(&r, seed);
	switch (fw_random_below(&r, 8)) {
	case 0:
	case 1: return text_put_word(&r, data, size, max, words[fw_random_below(&r, n)]);
	case 2: return text_spoil_order(&r, data, size, max, ',');
	case 3: return text_spoil_order(&r, data, size, max, '\n');
	default: return LLVMFuzzerMutate(data, size, max);
	}
}

#endif
