#include "source_logs.h"

#include <inttypes.h>
#include <math.h>
#include <string.h>

#include "furrow_meta.h"
#include "furrow_meta_columns.h"

#define BIT(column) (INT64_C(1) << (column))

typedef enum { LOG_NONE, LOG_DATAFLASH, LOG_ULOG, LOG_IMR, LOG_SOLUTIONS, LOG_TABLE } log_kind;

/* ---- the plan ---- */

static int complain(const tool *t, const char *name, const fw_imu_problem *problem)
{
	tool_error(t, "--%s: '%s': %s", name, problem->token, problem->reason);
	return EXIT_USAGE;
}

int log_plan_make(const tool *t, const char *columns, const char *axes, const char *time, log_plan *plan)
{
	fw_imu_problem problem;

	plan->instance = -1;
	plan->lag_s = (double)NAN;
	fw_imu_plan_begin(&plan->table);
	if (columns != NULL && fw_imu_parse_columns(columns, &plan->table.map, &problem) != FW_OK)
		return complain(t, "imu-columns", &problem);
	if (axes != NULL && fw_imu_parse_axes(axes, &plan->table.axes, &problem) != FW_OK)
		return complain(t, "imu-axes", &problem);
	if (time != NULL && fw_imu_parse_time(time, &plan->table.clock, &problem) != FW_OK)
		return complain(t, "imu-time", &problem);
	return EXIT_COMPLETE;
}

/* ---- what is it? ---- */

/* Text as far as one can see: no control characters but those of lines. */
static int is_text(const uint8_t *bytes, size_t n)
{
	for (size_t i = 0; i < n; i++)
		if (bytes[i] < ' ' && memchr("\t\r\n", bytes[i], 3) == NULL)
			return 0;
	return n > 0;
}

static log_kind detect(const source_job *j, const uint8_t *bytes, size_t n)
{
	if (fw_dataflash_detect(bytes, n) != FW_DATAFLASH_NONE)
		return LOG_DATAFLASH;
	if (fw_ulog_detect(bytes, n))
		return LOG_ULOG;
	if (fw_imr_detect(bytes, n))
		return LOG_IMR;
	if (fw_rtklib_pos_detect(bytes, n))
		return LOG_SOLUTIONS;
	if (fw_imu_text_detect(bytes, n))
		return LOG_TABLE;
	return j->plan->logs != NULL && j->plan->logs->table.map.given && is_text(bytes, n) ? LOG_TABLE
	                                                                                    : LOG_NONE;
}

int source_logs_detect(const source_job *j, const uint8_t *bytes, size_t n)
{
	return detect(j, bytes, n) != LOG_NONE;
}

/* ---- reading ---- */

/* A reader, whichever it is. */
typedef struct {
	fw_status (*read)(log_readers *now, fw_kind *kind, fw_any_record *record);
	void (*complain)(source_job *j); /* says what is lost */
	const bool *msl;                 /* heights are above mean sea level; NULL: they never are */
} reader;

/* Says so, in the output too. */
static void tell_heights(const source_job *j)
{
	static char key[] = "heights", value[] = "above mean sea level";
	furrow_meta meta = {.key = key, .value = value};
	fw_any_record record;

	tool_note(j->t, "%s: heights above mean sea level, it has no others", j->name);
	meta.present = BIT(FW_COL_meta_key) | BIT(FW_COL_meta_value);
	memcpy(&record, &meta, sizeof meta);
	source_put(j, FW_meta, &record);
}

static fw_status read_all(source_job *j, const reader *r)
{
	int told = r->msl == NULL;
	fw_any_record record;
	fw_kind kind;
	fw_status status = FW_EOF;

	while (!source_must_stop(j)) {
		status = r->read(j->logs, &kind, &record);
		if (status == FW_OK) {
			if (!told && *r->msl) {
				told = 1;
				tell_heights(j);
			}
			source_put(j, kind, &record);
		} else if (status == FW_ESYNTAX || status == FW_EUNKNOWN) {
			r->complain(j);
		}
		if (status != FW_OK && status != FW_ESYNTAX)
			break;
		tool_progress_update(&j->progress, (int64_t)j->input->offset);
	}
	return source_must_stop(j) ? FW_EOF : status;
}

/* A log that can be read twice is read once to learn its clock; then it is opened anew. Returns FW_OK. */
static fw_status rewind_job(source_job *j, fw_status survey)
{
	if (survey != FW_EOF && survey != FW_ETRUNCATED && survey != FW_EFORMAT)
		return survey;
	fw_input_close(j->input);
	return source_open(j);
}

static int is_file(const source_job *j)
{
	int64_t size;
	return source_is_file(j->path, &size);
}

static void note_untimed(const source_job *j, uint64_t n, const char *what)
{
	if (n > 0)
		tool_note(j->t, "%s: %" PRIu64 " %s without GPS time left out", j->name, n, what);
}

static void note_unhealthy(const source_job *j, uint64_t n)
{
	if (n > 0)
		tool_note(j->t,
		          "%s: %" PRIu64 " samples left out that are not finite, or not healthy as they say",
		          j->name, n);
}

/* ---- ArduPilot ---- */

static fw_status next_dataflash(log_readers *now, fw_kind *kind, fw_any_record *record)
{
	return fw_dataflash_read(&now->dataflash, kind, record);
}

static void complain_dataflash(source_job *j)
{
	const fw_dataflash *r = &j->logs->dataflash;
	tool_warn(j->t, CAUSE_DAMAGE, r->text ? "%s:%" PRIu64 ": %s" : "%s: byte %" PRIu64 ": %s", j->name,
	          r->lost_offset, r->reason);
}

static fw_status read_dataflash(source_job *j, const uint8_t *bytes, size_t n)
{
	fw_dataflash *r = &j->logs->dataflash;
	const log_plan *p = j->plan->logs;
	fw_dataflash_plan plan = fw_dataflash_default_plan();
	fw_status status = FW_OK;

	if (p != NULL) {
		plan.imu = p->instance;
		plan.lag_s = p->lag_s;
	}
	fw_dataflash_begin(r, j->input, fw_dataflash_detect(bytes, n), &plan);
	if (is_file(j)) {
		status = rewind_job(j, fw_dataflash_survey(r));
		fw_dataflash_again(r, j->input);
	}
	if (status == FW_OK)
		status = read_all(j, &(reader){next_dataflash, complain_dataflash, &r->msl});
	note_untimed(j, r->untimed, "messages");
	note_unhealthy(j, r->unhealthy);
	j->lost += r->lost + r->unhealthy;
	return status;
}

/* ---- PX4 ---- */

static fw_status next_ulog(log_readers *now, fw_kind *kind, fw_any_record *record)
{
	return fw_ulog_read(&now->ulog, kind, record);
}

static void complain_ulog(source_job *j)
{
	tool_warn(j->t, CAUSE_DAMAGE, "%s: byte %" PRIu64 ": %s", j->name, j->logs->ulog.lost_offset,
	          j->logs->ulog.reason);
}

static fw_status read_ulog(source_job *j)
{
	fw_ulog *r = &j->logs->ulog;
	const log_plan *p = j->plan->logs;
	fw_ulog_plan plan = fw_ulog_default_plan();
	fw_status status = FW_OK;

	if (p != NULL) {
		plan.imu = p->instance;
		plan.lag_s = p->lag_s;
	}
	fw_ulog_begin(r, j->input, &plan);
	if (is_file(j)) {
		status = fw_ulog_survey(r);
		status = rewind_job(j, status == FW_EUNKNOWN ? FW_EOF : status);
		fw_ulog_again(r, j->input);
	}
	if (status == FW_OK)
		status = read_all(j, &(reader){next_ulog, complain_ulog, &r->msl});
	if (r->dropouts > 0)
		tool_note(j->t, "%s: the autopilot dropped data %" PRIu64 " times, %" PRIu64 " ms in all",
		          j->name, r->dropouts, r->dropout_ms);
	note_untimed(j, r->untimed, "messages");
	note_unhealthy(j, r->unhealthy);
	j->lost += r->lost + r->unhealthy;
	return status;
}

/* ---- tables of sensor data ---- */

static fw_status next_line(log_readers *now, fw_kind *kind, fw_any_record *record)
{
	return fw_imu_text_read(&now->table, kind, record);
}

static void complain_line(source_job *j)
{
	const fw_imu_text_problem *p = &j->logs->table.problem;

	if (p->column > 0)
		tool_warn(j->t, CAUSE_ROW, "%s:%" PRIu64 ": column %d (%s): %s", j->name, p->line, p->column,
		          p->name, p->reason);
	else
		tool_warn(j->t, CAUSE_ROW, "%s:%" PRIu64 ": %s%s%s", j->name, p->line, p->name,
		          p->name[0] != '\0' ? ": " : "", p->reason);
}

static fw_status read_table(source_job *j)
{
	fw_imu_text *r = &j->logs->table;
	fw_status status = FW_OK;

	fw_imu_text_begin(r, j->input, j->plan->logs != NULL ? &j->plan->logs->table : NULL);
	if (fw_imu_text_wants_survey(r) && is_file(j)) {
		status = fw_imu_text_survey(r);
		status = rewind_job(j, status == FW_EUNKNOWN ? FW_EOF : status);
		fw_imu_text_again(r, j->input);
	}
	if (status == FW_OK)
		status = read_all(j, &(reader){next_line, complain_line, NULL});
	note_untimed(j, r->untimed, "lines");
	if (r->passed_over > 0)
		tool_note(j->t, "%s: %" PRIu64 " lines of other kinds passed over", j->name, r->passed_over);
	j->lost += r->lost;
	return status;
}

/* ---- Waypoint ---- */

static fw_status next_imr(log_readers *now, fw_kind *kind, fw_any_record *record)
{
	return fw_imr_read(&now->imr, kind, record);
}

static void complain_imr(source_job *j)
{
	tool_warn(j->t, CAUSE_DAMAGE, "%s: byte %" PRIu64 ": %s", j->name, j->logs->imr.lost_offset,
	          j->logs->imr.reason);
}

static fw_status read_imr(source_job *j)
{
	fw_imu_plan plan;

	fw_imu_plan_begin(&plan);
	fw_imr_begin(&j->logs->imr, j->input, j->plan->logs != NULL ? &j->plan->logs->table : &plan);
	const fw_status status = read_all(j, &(reader){next_imr, complain_imr, NULL});
	j->lost += j->logs->imr.lost;
	return status;
}

/* ---- RTKLIB's solutions ---- */

static fw_status next_solution(log_readers *now, fw_kind *kind, fw_any_record *record)
{
	return fw_rtklib_pos_read(&now->solutions, kind, record);
}

static void complain_solution(source_job *j)
{
	const fw_rinex_problem *p = &j->logs->solutions.problem;
	tool_warn(j->t, CAUSE_ROW, "%s:%" PRIu64 ": %s", j->name, p->line, p->reason);
}

static fw_status read_solutions(source_job *j)
{
	fw_rtklib_pos *r = &j->logs->solutions;

	fw_rtklib_pos_begin(r, j->input);
	const fw_status status = read_all(j, &(reader){next_solution, complain_solution, &r->msl});
	if (r->none > 0)
		tool_note(j->t, "%s: %" PRIu64 " lines without a solution", j->name, r->none);
	j->lost += r->lost;
	return status;
}

fw_status source_logs_read(source_job *j, const uint8_t *bytes, size_t n)
{
	switch (detect(j, bytes, n)) {
	case LOG_DATAFLASH: return read_dataflash(j, bytes, n);
	case LOG_ULOG: return read_ulog(j);
	case LOG_IMR: return read_imr(j);
	case LOG_SOLUTIONS: return read_solutions(j);
	case LOG_TABLE: return read_table(j);
	case LOG_NONE: break;
	}
	return FW_EOF;
}
