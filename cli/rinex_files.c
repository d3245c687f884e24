#include "rinex_files.h"

#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "formats/lcm_log.h"
#include "formats/rinex_write.h"
#include "formats/rinex_write_nav.h"
#include "output.h"

enum { NAVIGATION = FW_RINEX_ANTENNAS, FILES };

static const char *const names[FILES] = {"obs.rnx", "obs_aux1.rnx", "obs_aux2.rnx", "nav.rnx"};

static const fw_kind spooled[] = {FW_obs,     FW_event,   FW_eph_gps, FW_eph_gal,
                                  FW_eph_bds, FW_eph_glo, FW_eph_sbas};
static const fw_kind surveyed[] = {FW_setup, FW_pvt, FW_klobuchar, FW_nequick, FW_utc};

struct rinex_files {
	const tool *owner;
	const char *folder;
	uint64_t rows;
	fw_rinex_survey survey;
	output spool, out[FILES];
	int is_open[FILES];
	fw_lcm_writer log;
	fw_input input;
	fw_lcm_reader reader;
	union {
		fw_rinex_obs_writer obs;
		fw_rinex_nav_writer nav;
	} writer;
};

void rinex_files_wanted(fw_kind_set *wanted)
{
	for (size_t i = 0; i < sizeof spooled / sizeof *spooled; i++)
		fw_kind_add(wanted, spooled[i]);
	for (size_t i = 0; i < sizeof surveyed / sizeof *surveyed; i++)
		fw_kind_add(wanted, surveyed[i]);
}

static int open_one(rinex_files *f, output *out, const char *name)
{
	char path[PATH_MAX];

	errno = ENAMETOOLONG;
	if (snprintf(path, sizeof path, "%s/%s", f->folder, name) < (int)sizeof path &&
	    output_open(out, path) == FW_OK)
		return 1;
	tool_error(f->owner, "%s/%s: %s", f->folder, name, strerror(errno));
	return 0;
}

rinex_files *rinex_files_begin(const char *folder, const tool *t)
{
	rinex_files *f = calloc(1, sizeof *f);

	if (f == NULL) {
		tool_error(t, "%s: %s", folder, strerror(ENOMEM));
		return NULL;
	}
	f->owner = t;
	f->folder = folder;
	fw_rinex_survey_begin(&f->survey);
	if (!open_one(f, &f->spool, "records")) {
		free(f);
		return NULL;
	}
	fw_lcm_begin(&f->log, output_write, &f->spool);
	return f;
}

static int is_spooled(fw_kind kind)
{
	for (size_t i = 0; i < sizeof spooled / sizeof *spooled; i++)
		if (spooled[i] == kind)
			return 1;
	return 0;
}

void rinex_files_put(void *files, fw_kind kind, const void *record)
{
	rinex_files *f = files;

	fw_rinex_survey_put(&f->survey, kind, record);
	if (!is_spooled(kind))
		return;
	fw_lcm_put(&f->log, kind, record);
	f->rows += kind != FW_event;
}

int rinex_files_failed(const rinex_files *f)
{
	return f->spool.error != 0;
}

uint64_t rinex_files_rows(const rinex_files *f)
{
	return f->rows;
}

/* All that was kept, to a sink. */
static fw_status replay(rinex_files *f, fw_sink sink)
{
	fw_any_record record;
	fw_kind kind;
	fw_status status;

	do
		status = fw_input_open(&f->input, f->spool.aside);
	while (status == FW_EIO && f->input.error_number == EINTR && !tool_interrupted());
	if (status == FW_OK) {
		fw_lcm_begin_read(&f->reader, &f->input);
		while ((status = fw_lcm_read(&f->reader, &kind, &record)) == FW_OK)
			sink.put(sink.context, kind, &record);
	}
	if (status == FW_EIO)
		tool_error(f->owner, "%s: %s", f->spool.aside, strerror(f->input.error_number));
	else if (status != FW_EOF)
		tool_error(f->owner, "%s: %s", f->spool.aside, fw_status_text(status));
	fw_input_close(&f->input);
	return status == FW_EOF ? FW_OK : FW_EIO;
}

static void note_refused(const rinex_files *f, int which, uint64_t refused)
{
	if (refused > 0)
		tool_note(f->owner, "%s/%s: %" PRIu64 " records that RINEX cannot hold left out", f->folder,
		          names[which], refused);
}

static fw_status write_observations(rinex_files *f, int antenna)
{
	fw_rinex_obs_writer *w = &f->writer.obs;

	fw_rinex_obs_write(w, &f->survey, antenna, output_write, &f->out[antenna]);
	fw_status status = replay(f, (fw_sink){fw_rinex_obs_put, w});
	note_refused(f, antenna, w->refused);
	return fw_rinex_obs_end(w) == FW_OK ? status : FW_EIO;
}

static fw_status write_navigation(rinex_files *f)
{
	fw_rinex_nav_writer *w = &f->writer.nav;

	fw_rinex_nav_write(w, &f->survey, output_write, &f->out[NAVIGATION]);
	fw_status status = replay(f, (fw_sink){fw_rinex_nav_put, w});
	note_refused(f, NAVIGATION, w->refused);
	return fw_rinex_nav_end(w) == FW_OK ? status : FW_EIO;
}

/* Every file that there is something for, whole and on the disk, but not yet in its place. */
static fw_status write_files(rinex_files *f)
{
	for (int i = 0; i < FILES; i++) {
		if (!(i == NAVIGATION ? f->survey.has_navigation : f->survey.has_antenna[i]))
			continue;
		if (!open_one(f, &f->out[i], names[i]))
			return FW_EIO;
		f->is_open[i] = 1;
		if ((i == NAVIGATION ? write_navigation(f) : write_observations(f, i)) != FW_OK &&
		    f->out[i].error == 0)
			return FW_EIO;
		if (output_finish(&f->out[i]) != FW_OK) {
			tool_error(f->owner, "%s: %s", f->out[i].path, strerror(f->out[i].error));
			return FW_EIO;
		}
	}
	return FW_OK;
}

static fw_status commit(rinex_files *f, int keep)
{
	fw_status status = FW_OK;

	for (int i = 0; i < FILES; i++) {
		if (!f->is_open[i])
			continue;
		if (!keep) {
			output_discard(&f->out[i]);
		} else if (output_commit(&f->out[i]) != FW_OK) {
			tool_error(f->owner, "%s: %s", f->out[i].path, strerror(f->out[i].error));
			status = FW_EIO;
		}
	}
	return status;
}

fw_status rinex_files_end(rinex_files *f, int keep)
{
	fw_status status = FW_OK;

	if (fw_lcm_end(&f->log, true, 0) != FW_OK || rinex_files_failed(f)) {
		tool_error(f->owner, "%s: %s", f->spool.path, strerror(f->spool.error));
		status = FW_EIO;
	}
	if (status == FW_OK && keep)
		status = write_files(f);
	const fw_status committed = commit(f, keep && status == FW_OK);
	output_discard(&f->spool);
	free(f);
	return status != FW_OK ? status : committed;
}
