#include "sinks.h"

#include <dlfcn.h>
#include <errno.h>
#include <lcm/lcm.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>

/* Records that belong to the receiver's epochs: what --every thins out. */
static const fw_kind epoch_kinds[] = {
    FW_obs,  FW_epoch,     FW_obs_extra, FW_pvt,      FW_pvt_ecef, FW_dop,     FW_att,  FW_aux_ant,
    FW_base, FW_base_ecef, FW_satpos,    FW_residual, FW_raim,     FW_quality, FW_time, FW_status,
    FW_ins,  FW_ins_ecef,  FW_sbas_corr, FW_pl,       FW_pos,      FW_nav};

/* LCM over UDP loses messages when a sender bursts; up to this rate none are lost. */
enum { PUBLISH_PER_SECOND = 100000 };

static const char *type_at(const void *words, int i)
{
	(void)words;
	return fw_record_type_of((fw_kind)i)->name;
}

/* No record type is called so; which one is near? */
static void complain_unknown(const tool *t, const char *name, size_t n)
{
	char word[64];
	snprintf(word, sizeof word, "%.*s", (int)n, name);
	const char *nearest = nearest_word(word, type_at, NULL, FW_RECORD_COUNT);
	tool_error(t, "--types: no record type '%s'%s%s%s; furrow-stream(5) lists all", word,
	           nearest != NULL ? "; did you mean '" : "", nearest != NULL ? nearest : "",
	           nearest != NULL ? "'?" : "");
}

static void complain_other(const tool *t, const char *name, size_t n, const fw_kind *allowed, int n_allowed)
{
	char list[256] = "";
	for (int i = 0; i < n_allowed; i++) {
		const size_t used = strlen(list);
		snprintf(list + used, sizeof list - used, "%s%s", i > 0 ? ", " : "",
		         fw_record_type_of(allowed[i])->name);
	}
	tool_error(t, "--types: '%.*s' is not one of %s", (int)n, name, list);
}

static int is_allowed(fw_kind kind, const fw_kind *allowed, int n_allowed)
{
	for (int i = 0; i < n_allowed; i++)
		if (allowed[i] == kind)
			return 1;
	return allowed == NULL && kind != FW_RECORD_COUNT;
}

int sinks_parse_types(const tool *t, const char *text, const fw_kind *allowed, int n_allowed,
                      fw_kind_set *wanted, fw_kind *first)
{
	int n = 0;
	*wanted = (fw_kind_set){0};
	for (const char *p = text; *p != '\0';) {
		const size_t length = strcspn(p, ",");
		const fw_kind kind = fw_record_find(p, length);
		if (!is_allowed(kind, allowed, n_allowed)) {
			if (allowed == NULL)
				complain_unknown(t, p, length);
			else
				complain_other(t, p, length, allowed, n_allowed);
			return 0;
		}
		if (n == 0)
			*first = kind;
		n += !fw_kind_in(wanted, kind);
		fw_kind_add(wanted, kind);
		p += length + (p[length] == ',');
	}
	if (n == 0)
		tool_error(t, "--types: no type given");
	return n;
}

/* ---- publishing ---- */

/* liblcm brings GLib along, which aborts at program start when it gets no memory. So it is loaded by those who publish,
 * and nobody else depends on it. */
static struct {
	typeof(lcm_create) *create;
	typeof(lcm_publish) *publish;
	typeof(lcm_destroy) *destroy;
} liblcm;

/* Returns 0 after a message. */
static int load_liblcm(const tool *t)
{
	void *library = dlopen("liblcm.so.1", RTLD_NOW);
	if (library != NULL) {
		liblcm.create = (typeof(lcm_create) *)dlsym(library, "lcm_create");
		liblcm.publish = (typeof(lcm_publish) *)dlsym(library, "lcm_publish");
		liblcm.destroy = (typeof(lcm_destroy) *)dlsym(library, "lcm_destroy");
	}
	if (library != NULL && liblcm.create != NULL && liblcm.publish != NULL && liblcm.destroy != NULL)
		return 1;
	tool_error(t, "publishing needs LCM: %s", dlerror());
	return 0;
}

static int64_t now_ns(void)
{
	struct timespec t;
	clock_gettime(CLOCK_MONOTONIC, &t);
	return (int64_t)t.tv_sec * 1000000000 + t.tv_nsec;
}

/* Waits so that the mean rate since the start stays below PUBLISH_PER_SECOND; looks at the clock now and then. */
static void pace(sink_set *s)
{
	enum { BATCH = 100 };
	if (s->published % BATCH != 0)
		return;
	int64_t now = now_ns();
	if (s->next_publish_ns < now)
		s->next_publish_ns = now;
	int64_t ahead = s->next_publish_ns - now;
	if (ahead > 0) {
		struct timespec wait = {.tv_nsec = ahead};
		nanosleep(&wait, NULL);
	}
	s->next_publish_ns += BATCH * (INT64_C(1000000000) / PUBLISH_PER_SECOND);
}

static void publish(void *context, fw_kind kind, const void *record)
{
	static uint8_t buffer[160 * 1024];
	sink_set *s = context;
	fw_any_record rounded;
	size_t n;
	memcpy(&rounded, record, fw_record_type_of(kind)->size);
	fw_record_round(kind, &rounded);
	if (fw_record_encode(kind, &rounded, buffer, sizeof buffer, &n) != FW_OK)
		return;
	pace(s);
	if (liblcm.publish(s->lcm, fw_record_type_of(kind)->channel, buffer, (unsigned)n) != 0)
		s->failed = 1;
	s->published++;
}

/* ---- one table for each type ---- */

static sink_file *open_split(sink_set *s, fw_kind kind)
{
	char path[PATH_MAX];
	sink_file *f = malloc(sizeof *f);
	errno = f == NULL ? ENOMEM : ENAMETOOLONG;
	if (f != NULL &&
	    snprintf(path, sizeof path, "%s/%s.csv", s->plan.path, fw_record_type_of(kind)->name) <
	        (int)sizeof path &&
	    output_open(&f->out, path) == FW_OK) {
		fw_csv_begin_table(&f->writer.csv, kind, output_write, &f->out);
		return f;
	}
	tool_error(s->owner, "%s/%s.csv: %s", s->plan.path, fw_record_type_of(kind)->name, strerror(errno));
	free(f);
	s->failed = 1;
	return NULL;
}

static void put_split(void *context, fw_kind kind, const void *record)
{
	sink_set *s = context;
	if (s->failed)
		return;
	if (s->split[kind] == NULL)
		s->split[kind] = open_split(s, kind);
	if (s->split[kind] == NULL)
		return;
	fw_csv_put(&s->split[kind]->writer.csv, kind, record);
	if (s->split[kind]->out.error != 0)
		s->failed = 1;
}

/* ---- the filter by time ---- */

static int is_epoch_kind(fw_kind kind)
{
	for (size_t i = 0; i < sizeof epoch_kinds / sizeof epoch_kinds[0]; i++)
		if (epoch_kinds[i] == kind)
			return 1;
	return 0;
}

/* A record without a time is outside of every interval. */
static int is_kept(const sink_plan *plan, fw_kind kind, const void *record)
{
	fw_time t;
	if (fw_record_time(record, &t) != FW_OK)
		return plan->from == NULL && plan->until == NULL;
	if ((plan->from != NULL && t.ns < plan->from->ns) || (plan->until != NULL && t.ns >= plan->until->ns))
		return 0;
	return plan->every_ns == 0 || !is_epoch_kind(kind) || t.ns % FW_NS_PER_WEEK % plan->every_ns == 0;
}

static void filter(void *context, fw_kind kind, const void *record)
{
	sink_set *s = context;
	if (kind == FW_meta || is_kept(&s->plan, kind, record))
		s->writer.put(s->writer.context, kind, record);
}

/* ---- provenance ---- */

static void put_meta(sink_set *s, const char *key, const char *value)
{
	if (s->plan.mode == SINK_STREAM)
		fw_csv_meta(&s->file.writer.csv, key, value);
	else if (s->plan.mode == SINK_LCM)
		fw_lcm_meta(&s->file.writer.lcm, key, value);
}

static void put_setting(void *context, const char *key, const char *value)
{
	char text[512];
	/* Where the bytes go, and how much is said about it, is no property of the data. */
	static const char *const silent[] = {"output", "quiet",  "verbose", "progress",
	                                     "list",   "stream", "format"};
	for (size_t i = 0; i < sizeof silent / sizeof silent[0]; i++)
		if (strcmp(key, silent[i]) == 0)
			return;
	snprintf(text, sizeof text, "%s=%s", key, value);
	put_meta(context, "cfg", text);
}

static void put_provenance(sink_set *s, const options *o, int argc, char **argv)
{
	char text[2048];
	int n = snprintf(text, sizeof text, "tool=%s version=%s cl=%s", o->tool, FURROW_VERSION, o->tool);
	for (int i = 1; i < argc && n >= 0 && n < (int)sizeof text; i++)
		n += snprintf(text + n, sizeof text - (size_t)n, " %s", argv[i]);
	put_meta(s, "pg", text);
	options_each(o, put_setting, s);
}

/* ---- all together ---- */

static fw_status begin_file(sink_set *s)
{
	if (output_open(&s->file.out, s->plan.path) != FW_OK) {
		tool_error(s->owner, "%s: %s", s->file.out.path, strerror(s->file.out.error));
		return FW_EIO;
	}
	s->writer = (fw_sink){fw_csv_put, &s->file.writer.csv};
	if (s->plan.mode == SINK_TABLE) {
		fw_csv_begin_table(&s->file.writer.csv, s->plan.table, output_write, &s->file.out);
	} else if (s->plan.mode == SINK_STREAM) {
		fw_csv_begin_stream(&s->file.writer.csv, output_write, &s->file.out);
	} else {
		fw_lcm_begin(&s->file.writer.lcm, output_write, &s->file.out);
		s->writer = (fw_sink){fw_lcm_put, &s->file.writer.lcm};
	}
	return FW_OK;
}

static fw_status begin(sink_set *s, const sink_plan *plan)
{
	const tool *owner = s->owner;
	if (plan->mode == SINK_PUBLISH) {
		s->writer = (fw_sink){publish, s};
		if (!load_liblcm(owner))
			return FW_EIO;
		s->lcm = liblcm.create(plan->path);
		if (s->lcm == NULL) {
			tool_error(owner, "%s: LCM cannot publish there", plan->path);
			return FW_EIO;
		}
		return FW_OK;
	}
	if (plan->mode == SINK_SPLIT || plan->mode == SINK_RINEX) {
		if (mkdir(plan->path, 0777) != 0 && errno != EEXIST) {
			tool_error(owner, "%s: %s", plan->path, strerror(errno));
			return FW_EIO;
		}
		s->writer = (fw_sink){put_split, s};
	}
	if (plan->mode == SINK_RINEX) {
		s->rinex = rinex_files_begin(plan->path, owner);
		s->writer = (fw_sink){rinex_files_put, s->rinex};
		return s->rinex != NULL ? FW_OK : FW_EIO;
	}
	if (plan->mode == SINK_SPLIT)
		return FW_OK;
	return begin_file(s);
}

fw_status sinks_begin(sink_set *s, const sink_plan *plan, const tool *owner, const options *o, int argc,
                      char **argv)
{
	s->plan = *plan;
	s->owner = owner;
	fw_status status = begin(s, plan);
	if (status != FW_OK)
		return status;
	put_provenance(s, o, argc, argv);
	s->writer = relay_start(&s->relay, s->writer);
	return FW_OK;
}

fw_sink sinks_head(sink_set *s)
{
	if (s->plan.from == NULL && s->plan.until == NULL && s->plan.every_ns == 0)
		return s->writer;
	return (fw_sink){filter, s};
}

void sinks_flush(sink_set *s)
{
	relay_drain(&s->relay);
	if (s->plan.mode == SINK_TABLE || s->plan.mode == SINK_STREAM)
		(void)!fw_csv_flush(&s->file.writer.csv);
	else if (s->plan.mode == SINK_LCM)
		(void)!fw_lcm_flush(&s->file.writer.lcm);
}

int sinks_failed(const sink_set *s)
{
	return s->failed || s->file.out.error != 0 || (s->rinex != NULL && rinex_files_failed(s->rinex));
}

void sinks_stop(sink_set *s)
{
	relay_stop(&s->relay);
}

uint64_t sinks_rows(const sink_set *s)
{
	uint64_t rows = 0;
	switch (s->plan.mode) {
	case SINK_TABLE:
	case SINK_STREAM: return s->file.writer.csv.rows;
	case SINK_LCM: return s->file.writer.lcm.rows;
	case SINK_PUBLISH: return s->published;
	case SINK_RINEX: return s->rinex != NULL ? rinex_files_rows(s->rinex) : 0;
	case SINK_SPLIT: break;
	}
	for (int kind = 0; kind < FW_RECORD_COUNT; kind++)
		if (s->split[kind] != NULL)
			rows += s->split[kind]->writer.csv.rows;
	return rows;
}

uint64_t sinks_refused(const sink_set *s)
{
	uint64_t refused = 0;
	if (s->plan.mode == SINK_LCM)
		return s->file.writer.lcm.refused;
	if (s->plan.mode == SINK_TABLE || s->plan.mode == SINK_STREAM)
		return s->file.writer.csv.refused;
	for (int kind = 0; kind < FW_RECORD_COUNT; kind++)
		if (s->split[kind] != NULL)
			refused += s->split[kind]->writer.csv.refused;
	return refused;
}

static fw_status close_file(const tool *t, output *out, int keep)
{
	if (out->error == 0 && !keep) {
		output_discard(out);
		return FW_OK;
	}
	if (output_commit(out) == FW_OK)
		return FW_OK;
	tool_error(t, "%s: %s", out->path, strerror(out->error));
	return FW_EIO;
}

/* All tables are on the disk before the first takes its place: the old set stays when one of them fails. */
static fw_status end_split(sink_set *s, const tool *t, int complete, uint64_t lost, int keep)
{
	for (int kind = 0; kind < FW_RECORD_COUNT; kind++) {
		sink_file *f = s->split[kind];
		if (f != NULL &&
		    (fw_csv_end(&f->writer.csv, complete, lost) != FW_OK || output_finish(&f->out) != FW_OK))
			s->failed = 1;
	}
	fw_status worst = s->failed ? FW_EIO : FW_OK;
	for (int kind = 0; kind < FW_RECORD_COUNT; kind++) {
		sink_file *f = s->split[kind];
		if (f == NULL)
			continue;
		fw_status status = close_file(t, &f->out, keep && !s->failed);
		worst = status != FW_OK ? status : worst;
		free(f);
		s->split[kind] = NULL;
	}
	return worst;
}

fw_status sinks_end(sink_set *s, const tool *t, int complete, uint64_t lost, int keep)
{
	switch (s->plan.mode) {
	case SINK_PUBLISH:
		liblcm.destroy(s->lcm);
		if (s->failed)
			tool_error(t, "%s: publishing failed", s->plan.path);
		return s->failed ? FW_EIO : FW_OK;
	case SINK_SPLIT: return end_split(s, t, complete, lost, keep);
	case SINK_RINEX: return rinex_files_end(s->rinex, keep);
	case SINK_LCM: (void)!fw_lcm_end(&s->file.writer.lcm, complete, lost); break;
	case SINK_TABLE:
	case SINK_STREAM: (void)!fw_csv_end(&s->file.writer.csv, complete, lost); break;
	}
	return close_file(t, &s->file.out, keep);
}
