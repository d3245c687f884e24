#include "source.h"

#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>

#include "formats/csv.h"
#include "formats/input.h"
#include "formats/lcm_log.h"
#include "formats/rinex_nav.h"
#include "formats/rinex_obs.h"
#include "formats/sbf_decoder.h"
#include "formats/sbf_schema.h"
#include "source_logs.h"

typedef enum {
	CONTENT_SBF,
	CONTENT_TEXT,
	CONTENT_LCM,
	CONTENT_RINEX_OBSERVATION,
	CONTENT_RINEX_NAVIGATION,
	CONTENT_RINEX_OTHER,
	CONTENT_ORBITS,   /* SP3 */
	CONTENT_COMPRESS, /* .Z */
	CONTENT_OTHER_LOG /* see source_logs.h */
} content;

/* What reading a file takes: large, and no heap in it. One set serves all who read one file after the other. */
struct source_readers {
	fw_input input;
	union {
		struct {
			fw_sbf_framer framer;
			fw_sbf_decoder decoder;
		} sbf;
		fw_csv_reader csv;
		fw_lcm_reader lcm;
		fw_rinex_obs rinex_obs;
		fw_rinex_nav rinex_nav;
		log_readers logs;
	} reader;
};
static source_readers shared;
static _Thread_local source_readers *now;

/* ---- what is it? ---- */

/* The whole first line, or as much of it as was peeked at. */
static int line_contains(const uint8_t *bytes, size_t n, const char *word)
{
	const uint8_t *end = memchr(bytes, '\n', n);
	return memmem(bytes, end != NULL ? (size_t)(end - bytes) : n, word, strlen(word)) != NULL;
}

static content detect(const source_job *j, const uint8_t *bytes, size_t n)
{
	static const uint8_t lcm_sync[] = {0xED, 0xA1, 0xDA, 0x01};
	if (n >= sizeof lcm_sync && memcmp(bytes, lcm_sync, sizeof lcm_sync) == 0)
		return CONTENT_LCM;
	if (n >= 2 && memcmp(bytes, "$@", 2) == 0)
		return CONTENT_SBF;
	if (n >= 15 && memcmp(bytes, "#furrow-stream ", 15) == 0)
		return CONTENT_TEXT;
	if (line_contains(bytes, n, "gps_week") && line_contains(bytes, n, "tow_s"))
		return CONTENT_TEXT;
	switch (fw_rinex_detect(bytes, n)) {
	case FW_RINEX_OBSERVATION: return CONTENT_RINEX_OBSERVATION;
	case FW_RINEX_NAVIGATION: return CONTENT_RINEX_NAVIGATION;
	case FW_RINEX_OTHER: return CONTENT_RINEX_OTHER;
	case FW_RINEX_NONE: break;
	}
	if (n >= 4 && bytes[0] == '#' && bytes[1] >= 'a' && bytes[1] <= 'd' &&
	    (bytes[2] == 'P' || bytes[2] == 'V'))
		return CONTENT_ORBITS;
	if (n >= 2 && bytes[0] == 0x1f && bytes[1] == 0x9d)
		return CONTENT_COMPRESS;
	if (source_logs_detect(j, bytes, n))
		return CONTENT_OTHER_LOG;
	return CONTENT_SBF;
}

int source_must_stop(const source_job *j)
{
	return tool_interrupted() || (j->plan->sinks != NULL && sinks_failed(j->plan->sinks));
}

/* ---- SBF ---- */

static void note_loss(void *context, const fw_sbf_loss *loss)
{
	source_job *j = context;
	char block[64] = "block";
	if (loss->status == FW_ETRUNCATED && tool_interrupted())
		return; /* not the log's end but ours */
	j->lost++;
	if (loss->id != 0)
		snprintf(block, sizeof block, "block %s%s(%u)", fw_sbf_block_name(loss->id),
		         fw_sbf_block_name(loss->id)[0] != '\0' ? " " : "", (unsigned)loss->id);
	if (j->plan->blocks != NULL)
		inventory_add_loss(j->plan->blocks, loss);
	if (loss->status == FW_ETRUNCATED)
		tool_warn(j->t, CAUSE_TRUNCATED, "%s: byte %" PRIu64 ": the log ends inside a %s", j->name,
		          loss->offset, block);
	else
		tool_warn(j->t, CAUSE_DAMAGE, "%s: byte %" PRIu64 ": %s: %s, skipped", j->name, loss->offset,
		          block, loss->status == FW_ECHECKSUM ? "CRC mismatch" : "damaged header");
}

static fw_status read_blocks(source_job *j, fw_sbf_framer *framer, fw_sbf_decoder *decoder)
{
	fw_status status = FW_EOF;
	fw_sbf_block block;
	while (!source_must_stop(j) && (status = fw_sbf_next(framer, &block)) == FW_OK) {
		if (j->plan->blocks != NULL)
			inventory_add(j->plan->blocks, &block);
		else
			fw_sbf_decoder_put(decoder, &block);
		tool_progress_update(&j->progress, (int64_t)block.offset);
	}
	return source_must_stop(j) ? FW_EOF : status;
}

/* What the user should know about what was not decoded. */
static void explain(const source_job *j, const fw_sbf_decoder_stats *s)
{
	if (s->scrambled > 0)
		tool_note(j->t, "%s: %" PRIu64 " epochs of scrambled measurements left out", j->name,
		          s->scrambled);
	if (s->no_reference > 0)
		tool_note(j->t, "%s: %" PRIu64 " Meas3 epochs without their reference epoch left out",
		          j->name, s->no_reference);
	if (s->left_out.other_antenna > 0)
		tool_note(j->t, "%s: %" PRIu64 " observations of other antennas left out (--antenna)",
		          j->name, s->left_out.other_antenna);
	if (s->left_out.unnamed > 0)
		tool_note(j->t, "%s: %" PRIu64 " observations of GLONASS satellites of unknown slot left out",
		          j->name, s->left_out.unnamed);
	if (s->bad_pages > 0)
		tool_note(j->t, "%s: %" PRIu64 " navigation pages fail their checksum", j->name,
		          s->bad_pages);
}

static fw_status read_sbf(source_job *j)
{
	fw_sbf_framer *framer = &now->reader.sbf.framer;
	fw_sbf_decoder *decoder = &now->reader.sbf.decoder;
	fw_sbf_decoder_options o = {j->plan->wanted, j->plan->antennas, j->plan->nav_sources};

	fw_sbf_init(framer, &now->input, note_loss, j);
	fw_sbf_decoder_init(decoder, &o, j->sink);
	fw_status status = read_blocks(j, framer, decoder);
	fw_sbf_decoder_flush(decoder);

	const fw_sbf_stats *s = &framer->stats;
	if (s->blocks == 0)
		tool_note(j->t, "%s: no SBF block in it, and it is no stream, table or LCM log either",
		          j->name);
	explain(j, &decoder->stats);
	j->lost += decoder->stats.malformed + decoder->stats.scrambled + decoder->stats.no_reference;
	fw_sbf_decoder_offered(decoder, &j->totals->offered);
	j->totals->blocks += s->blocks;
	j->totals->bytes_skipped += s->bytes_skipped;
	j->totals->unknown += decoder->stats.unknown;
	return status;
}

/* ---- streams, tables, LCM logs ---- */

void source_put(const source_job *j, fw_kind kind, const fw_any_record *record)
{
	if (j->plan->blocks == NULL && (kind == FW_meta || fw_kind_in(&j->plan->wanted, kind)))
		j->sink.put(j->sink.context, kind, record);
	if (kind == FW_meta)
		return;
	fw_kind_add(&j->totals->offered, kind);
	j->totals->records++;
}

static fw_status read_text(source_job *j)
{
	fw_csv_reader *r = &now->reader.csv;
	fw_any_record record;
	fw_kind kind;
	fw_status status = FW_EOF;

	fw_csv_begin_read(r, &now->input, j->plan->table);
	while (!source_must_stop(j) && (status = fw_csv_read(r, &kind, &record)) != FW_EOF) {
		if (status == FW_OK) {
			source_put(j, kind, &record);
		} else if (status == FW_ESYNTAX || status == FW_EUNKNOWN) {
			tool_warn(j->t, CAUSE_ROW, "%s:%" PRIu64 ": column %d %s: %s", j->name,
			          r->problem.line, r->problem.field, r->problem.column, r->problem.reason);
		}
		if (status < 0 && status != FW_ESYNTAX)
			break;
		tool_progress_update(&j->progress, (int64_t)now->input.offset);
	}
	if (r->unknown_columns > 0)
		tool_note(j->t, "%s: %d unknown columns ignored, '%s' first", j->name, r->unknown_columns,
		          r->unknown);
	j->lost += r->lost + r->skipped + (status == FW_EUNKNOWN);
	j->partial |= r->partial;
	return source_must_stop(j) ? FW_EOF : status;
}

static fw_status read_lcm(source_job *j)
{
	fw_lcm_reader *r = &now->reader.lcm;
	fw_any_record record;
	fw_kind kind;
	fw_status status = FW_EOF;

	fw_lcm_begin_read(r, &now->input);
	while (!source_must_stop(j) && (status = fw_lcm_read(r, &kind, &record)) != FW_EOF) {
		if (status == FW_OK)
			source_put(j, kind, &record);
		else if (status == FW_ESYNTAX)
			tool_warn(j->t, CAUSE_DAMAGE, "%s: byte %" PRIu64 ": %s", j->name, r->lost_offset,
			          r->reason);
		else
			break;
		tool_progress_update(&j->progress, (int64_t)now->input.offset);
	}
	if (r->foreign > 0)
		tool_note(j->t, "%s: %" PRIu64 " events on other channels passed over", j->name, r->foreign);
	j->lost += r->lost + r->skipped;
	j->partial |= r->partial;
	return source_must_stop(j) ? FW_EOF : status;
}

/* ---- RINEX ---- */

/* One problem of a file of lines. */
static void note_problem(const source_job *j, const fw_rinex_problem *problem)
{
	tool_warn(j->t, CAUSE_ROW, "%s:%" PRIu64 ": %s", j->name, problem->line, problem->reason);
}

/* Observations come by the million: a look around every so many of them is enough. */
enum { ROWS_BETWEEN_LOOKS = 64 };

static fw_status read_observations(source_job *j)
{
	fw_rinex_obs *r = &now->reader.rinex_obs;
	fw_any_record record;
	fw_kind kind;
	fw_status status = FW_EOF;

	fw_rinex_obs_begin(r, &now->input);
	r->no_carriers = j->plan->no_carriers;
	for (unsigned row = 0; row % ROWS_BETWEEN_LOOKS != 0 || !source_must_stop(j); row++) {
		status = fw_rinex_obs_read(r, &kind, &record);
		if (status == FW_OK)
			source_put(j, kind, &record);
		else if (status != FW_ESYNTAX)
			break;
		else
			note_problem(j, &r->problem);
		if (row % ROWS_BETWEEN_LOOKS == 0)
			tool_progress_update(&j->progress, (int64_t)now->input.offset);
	}
	if (status == FW_EUNKNOWN)
		note_problem(j, &r->problem);
	j->lost += r->lost;
	return source_must_stop(j) ? FW_EOF : status;
}

static fw_status read_navigation(source_job *j)
{
	fw_rinex_nav *r = &now->reader.rinex_nav;
	fw_any_record record;
	fw_kind kind;
	fw_status status = FW_EOF;

	fw_rinex_nav_begin(r, &now->input);
	while (!source_must_stop(j)) {
		status = fw_rinex_nav_read(r, &kind, &record);
		if (status == FW_OK)
			source_put(j, kind, &record);
		else if (status != FW_ESYNTAX)
			break;
		else
			note_problem(j, &r->problem);
		tool_progress_update(&j->progress, (int64_t)now->input.offset);
	}
	if (status == FW_EUNKNOWN)
		note_problem(j, &r->problem);
	if (r->passed_over > 0)
		tool_note(j->t, "%s: %" PRIu64 " entries of messages that are not decoded passed over",
		          j->name, r->passed_over);
	j->lost += r->lost;
	return source_must_stop(j) ? FW_EOF : status;
}

/* ---- a file ---- */

/* A file that is known, but not read here. */
static fw_status refuse(source_job *j, const char *why)
{
	tool_note(j->t, "%s: %s", j->name, why);
	j->lost++;
	return FW_EOF;
}

int source_is_file(const char *path, int64_t *size)
{
	struct stat s;
	int is_file = strcmp(path, "-") != 0 && stat(path, &s) == 0 && S_ISREG(s.st_mode);
	*size = is_file ? s.st_size : 0;
	return is_file;
}

static void start_progress(source_job *j, const char *path)
{
	int64_t size;
	source_is_file(path, &size);
	tool_progress_start(&j->progress, j->t, j->plan->progress, j->name, now->input.gzip ? 0 : size);
}

static fw_status read_content(source_job *j, const char *path)
{
	const uint8_t *head;
	size_t n = 0;
	/* A live log may say little and then pause: no more than its sync is waited for. */
	fw_status status = fw_input_peek(&now->input, 2, &head, &n);
	if (status == FW_OK && memcmp(head, "$@", n < 2 ? n : 2) != 0)
		status = fw_input_peek(&now->input, 512, &head, &n);
	if (status == FW_EOF)
		tool_note(j->t, "%s: empty", j->name);
	if (status != FW_OK)
		return status;
	start_progress(j, path);
	switch (detect(j, head, n)) {
	case CONTENT_TEXT: status = read_text(j); break;
	case CONTENT_LCM: status = read_lcm(j); break;
	case CONTENT_SBF: status = read_sbf(j); break;
	case CONTENT_RINEX_OBSERVATION: status = read_observations(j); break;
	case CONTENT_RINEX_NAVIGATION: status = read_navigation(j); break;
	case CONTENT_RINEX_OTHER:
		status = refuse(j, "neither observations nor navigation of RINEX 2, 3 or 4");
		break;
	case CONTENT_ORBITS: status = refuse(j, "precise orbits (SP3) have no records"); break;
	case CONTENT_COMPRESS:
		status = refuse(
		    j,
		    "compressed with compress(1): use gzip, or uncompress it on the way (zcat FILE | ...)");
		break;
	case CONTENT_OTHER_LOG: status = source_logs_read(j, head, n); break;
	}
	tool_progress_end(&j->progress);
	return status;
}

/* The input pauses: a live receiver. */
static void hand_on(void *context)
{
	const source_plan *plan = ((const source_job *)context)->plan;
	if (plan->pause != NULL)
		plan->pause(plan->pause_context);
	else if (plan->sinks != NULL)
		sinks_flush(plan->sinks);
}

/* By mmap: it is large, and of most of it no more than the address is ever taken. */
source_readers *source_readers_new(void)
{
	void *p =
	    mmap(NULL, sizeof(source_readers), PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
	return p != MAP_FAILED ? p : NULL;
}

void source_readers_free(source_readers *r)
{
	if (r != NULL)
		munmap(r, sizeof *r);
}

fw_status source_open(source_job *j)
{
	fw_status status;
	do
		status = fw_input_open(j->input, j->path);
	while (status == FW_EIO && j->input->error_number == EINTR && !tool_interrupted());
	if (status == FW_OK) {
		j->input->stop = tool_stop_flag();
		j->input->idle = hand_on;
		j->input->idle_context = j;
	}
	return status;
}

int source_read(tool *t, const char *path, const source_plan *plan, fw_sink sink, source_totals *totals)
{
	now = plan->readers != NULL ? plan->readers : &shared;
	source_job j = {.t = t,
	                .name = strcmp(path, "-") == 0 ? "standard input" : path,
	                .path = path,
	                .plan = plan,
	                .sink = sink,
	                .totals = totals,
	                .input = &now->input,
	                .logs = &now->reader.logs};
	fw_status status = source_open(&j);
	if (status == FW_OK)
		status = read_content(&j, path);
	fw_input_close(&now->input);
	int error = now->input.error_number;
	int failed = (status == FW_EIO || status == FW_ENOMEM) && !tool_interrupted();
	if (failed)
		tool_error(t, "%s: %s", j.name, status == FW_EIO ? strerror(error) : fw_status_text(status));
	else if (status == FW_ETRUNCATED)
		tool_warn(t, CAUSE_TRUNCATED, "%s: cut short", j.name);
	else if (status == FW_EFORMAT)
		tool_warn(t, CAUSE_DAMAGE, "%s: gzip data damaged, the rest is lost", j.name);
	j.lost += status == FW_ETRUNCATED || status == FW_EFORMAT;
	totals->lost += j.lost;
	if (failed)
		return EXIT_IO;
	return j.lost > 0 || j.partial || totals->bytes_skipped > 0 ? EXIT_PARTIAL : EXIT_COMPLETE;
}

int source_read_all(tool *t, int n, char **files, const source_plan *plan, fw_sink sink,
                    source_totals *totals)
{
	static char dash[] = "-", *standard_input[] = {dash};
	int worst = EXIT_COMPLETE;
	if (n == 0) {
		n = 1;
		files = standard_input;
	}
	for (int i = 0; i < n && !tool_interrupted(); i++) {
		if (plan->sinks != NULL && sinks_failed(plan->sinks))
			break;
		int status = source_read(t, files[i], plan, sink, totals);
		if (status > worst)
			worst = status;
	}
	return worst;
}

void source_offer(const tool *t, const source_totals *totals)
{
	char names[1024] = "";
	for (fw_kind kind = 0; kind < FW_RECORD_COUNT; kind++) {
		if (!fw_kind_in(&totals->offered, kind))
			continue;
		size_t used = strlen(names);
		snprintf(names + used, sizeof names - used, " %s", fw_record_type_of(kind)->name);
	}
	if (names[0] != '\0')
		tool_note(t, "nothing of what was asked for is there; what is:%s", names);
}

void source_summary(const tool *t, const source_totals *totals, uint64_t rows)
{
	char unknown[64] = "";
	if (totals->unknown > 0)
		snprintf(unknown, sizeof unknown, " (%" PRIu64 " of types not decoded)", totals->unknown);
	if (totals->records > 0)
		tool_note(t, "%" PRIu64 " records read, %" PRIu64 " lost, %" PRIu64 " rows written",
		          totals->records, totals->lost, rows);
	else
		tool_note(t,
		          "%" PRIu64 " blocks%s, %" PRIu64 " lost, %" PRIu64 " bytes skipped, %" PRIu64
		          " rows written",
		          totals->blocks, unknown, totals->lost, totals->bytes_skipped, rows);
}
