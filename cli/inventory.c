#include "inventory.h"

#include <stdio.h>
#include <string.h>

#include "formats/number.h"
#include "formats/sbf_decoder.h"
#include "formats/sbf_schema.h"

static const char columns[] =
    "block_id,name,revision,count,first_gps_week,first_tow_s,last_gps_week,last_tow_s,"
    "rate_hz,bytes,error_share,record\n";

void inventory_add(inventory *inv, const fw_sbf_block *block)
{
	inventory_entry *e = &inv->entries[block->id][block->revision];
	fw_time t;
	e->count++;
	e->bytes += block->length;
	if (block->week == FW_SBF_NO_WEEK || block->tow_ms == FW_SBF_NO_TOW ||
	    fw_time_from_gps(block->week, (int64_t)block->tow_ms * 1000000, &t) != FW_OK)
		return;
	if (e->stamped == 0 || t.ns < e->first.ns)
		e->first = t;
	if (e->stamped == 0 || t.ns > e->last.ns)
		e->last = t;
	e->stamped++;
}

void inventory_add_loss(inventory *inv, const fw_sbf_loss *loss)
{
	inv->damaged[loss->id % INVENTORY_IDS]++;
}

static char *put_text(char *p, const char *text)
{
	size_t n = strlen(text);
	memcpy(p, text, n);
	return p + n;
}

/* ",week,tow" */
static char *put_time(char *p, fw_time t)
{
	int32_t week;
	int64_t tow_ns;
	fw_time_to_gps(t, &week, &tow_ns);
	*p++ = ',';
	p = fw_put_i64(p, week);
	*p++ = ',';
	return fw_put_fixed_trim(p, (double)tow_ns / 1e9, 9);
}

static void write_row(const inventory *inv, unsigned id, int revision, output *out)
{
	static const inventory_entry none;
	const inventory_entry *e = revision >= 0 ? &inv->entries[id][revision] : &none;
	uint64_t intact = 0;
	char row[512], *p = row;

	for (int r = 0; r < INVENTORY_REVISIONS; r++)
		intact += inv->entries[id][r].count;
	p = fw_put_u64(p, id);
	*p++ = ',';
	p = put_text(p, fw_sbf_block_name((uint16_t)id));
	*p++ = ',';
	if (revision >= 0)
		p = fw_put_u64(p, (uint64_t)revision);
	*p++ = ',';
	p = fw_put_u64(p, e->count);
	if (e->stamped > 0) {
		p = put_time(p, e->first);
		p = put_time(p, e->last);
		double span_s = (double)(e->last.ns - e->first.ns) / 1e9;
		*p++ = ',';
		if (span_s > 0)
			p = fw_put_fixed_trim(p, (double)(e->stamped - 1) / span_s, 3);
	} else {
		p = put_text(p, ",,,,,");
	}
	*p++ = ',';
	p = fw_put_u64(p, e->bytes);
	*p++ = ',';
	p = fw_put_fixed_trim(p, (double)inv->damaged[id] / (double)(inv->damaged[id] + intact), 6);
	*p++ = ',';
	p = put_text(p, fw_sbf_decoder_records((uint16_t)id));
	*p++ = '\n';
	(void)!output_write(out, row, (size_t)(p - row));
}

void inventory_write(const inventory *inv, output *out)
{
	(void)!output_write(out, columns, sizeof columns - 1);
	for (unsigned id = 0; id < INVENTORY_IDS; id++) {
		int found = 0;
		for (int revision = 0; revision < INVENTORY_REVISIONS; revision++) {
			if (inv->entries[id][revision].count == 0)
				continue;
			write_row(inv, id, revision, out);
			found = 1;
		}
		if (!found && inv->damaged[id] > 0 && id > 0)
			write_row(inv, id, -1, out);
	}
}
