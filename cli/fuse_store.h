/* A long list of records of one size: in memory as long as a budget lasts, then in a file without a name. */
#ifndef FURROW_CLI_FUSE_STORE_H
#define FURROW_CLI_FUSE_STORE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* What several lists share. */
typedef struct {
	uint64_t memory_left;              /* [bytes] */
	uint64_t in_memory, in_file, most; /* bytes in use; most at any time */
	int fd;                            /* of the file; -1: none yet */
	int64_t file_end;                  /* [bytes] */
	int error;                         /* errno of the first failure; 0: none */
} fuse_budget;

typedef struct {
	char *memory;   /* NULL: in the file */
	int64_t offset; /* in the file */
} fuse_chunk;

/* Owned by the caller. */
typedef struct {
	fuse_budget *budget;
	size_t size; /* of a record [bytes] */
	uint64_t n;  /* records */
	uint64_t per_chunk;
	fuse_chunk *chunk;
	size_t n_chunks, room;
	char *window;     /* the chunk of the file that is looked at */
	size_t in_window; /* its number; SIZE_MAX: none */
	bool changed;     /* it differs from the file */
} fuse_store;

void fuse_budget_begin(fuse_budget *b, uint64_t memory);

/* Closes the file. The lists have to be ended before. */
void fuse_budget_end(fuse_budget *b);

void fuse_store_begin(fuse_store *s, fuse_budget *budget, size_t size);

/* A new record at the end, all zero, to be filled in; and record i < n, to be looked at. Where it is, until the next call for this
 * list. NULL: no memory, no room on the disk, the disk fails; budget->error says which. */
void *fuse_store_add(fuse_store *s);
const void *fuse_store_at(fuse_store *s, uint64_t i);

/* Empties the list and gives back its memory. */
void fuse_store_end(fuse_store *s);

#endif
