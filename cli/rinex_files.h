/* `-f rinex --split DIR`: records to DIR/obs.rnx (obs_aux1.rnx, obs_aux2.rnx for other antennas) and
 * DIR/nav.rnx.
 *
 * A RINEX header says what is in the file, so all records have to be seen before the first line can be
 * written. They are kept meanwhile in a file beside the outputs, an LCM log that is gone afterwards: memory
 * does not grow, and what is read may be a pipe. */
#ifndef FURROW_CLI_RINEX_FILES_H
#define FURROW_CLI_RINEX_FILES_H

#include "formats/record.h"
#include "tool.h"

typedef struct rinex_files rinex_files;

/* The record types that the files are made of. */
void rinex_files_wanted(fw_kind_set *wanted);

/* Begins. `folder` must exist and outlive the result. NULL after a message. */
rinex_files *rinex_files_begin(const char *folder, const tool *t);

/* Takes a record: the `put` of a fw_sink whose context is the rinex_files. */
void rinex_files_put(void *files, fw_kind kind, const void *record);

/* Whether keeping records has failed; a message will come from rinex_files_end(). */
int rinex_files_failed(const rinex_files *f);

/* Observations and ephemerides taken so far. */
uint64_t rinex_files_rows(const rinex_files *f);

/* Writes the files, if `keep`, and frees everything. All take their place, or none: FW_EIO after a message. */
fw_status rinex_files_end(rinex_files *f, int keep) FW_MUST_CHECK;

#endif
