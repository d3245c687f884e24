/* Records to blocks: whatever an LCM log holds, the block made of it is one that decodes. */
#include "lcm_input.h"

#include "formats/sbf_build.h"

#include "record_check.h"

static fw_sbf_plans plans;
static fw_kind_set all;
static unsigned n_emitted;

size_t fuzz_make(fw_random *random, uint8_t *data)
{
	return lcm_make(random, data, FUZZ_ROOM);
}

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t max, unsigned seed)
{
	return lcm_mutate(data, size, max, seed);
}

static void take(void *context, fw_kind kind, const void *record)
{
	record_check(context, kind, record);
	n_emitted++;
}

static void build(const fw_sbf_schema *schema, const void *const *records, size_t n)
{
	static fw_sbf_values values;
	static uint8_t block[FW_SBF_MAX_LENGTH];
	uint16_t length = 0;

	if (fw_sbf_build(&plans, schema->id, schema->revision, records, n, block, &length) != FW_OK)
		return;
	require(length >= FW_SBF_BODY && length % 4 == 0);
	require(fw_sbf_decode(block, &values) == FW_OK);
	n_emitted = 0;
	require(fw_sbf_emit(&plans, block, length, &all, (fw_sink){take, NULL}) == FW_OK);
	require(n_emitted <= n);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
	static fw_input in;
	static fw_lcm_reader reader;
	static fw_any_record record;
	const void *const records[] = {&record, &record};
	fw_kind kind;
	fw_status status;

	if (plans.n_steps == 0) {
		fw_sbf_plans_init(&plans);
		for (kind = 0; kind < FW_RECORD_COUNT; kind++)
			fw_kind_add(&all, kind);
	}
	fw_input_open_memory(&in, data, size);
	fw_lcm_begin_read(&reader, &in);
	while ((status = fw_lcm_read(&reader, &kind, &record)) == FW_OK || status == FW_ESYNTAX) {
		for (int i = 0; i < fw_sbf_n_schemas && status == FW_OK; i++) {
			if (fw_sbf_schemas[i].kind != kind)
				continue;
			build(&fw_sbf_schemas[i], records, 1);
			build(&fw_sbf_schemas[i], records, 2);
		}
	}
	return 0;
}
