/* SBAS messages, one behind the other. Records that a message gave make a message that gives them again. */
#include "nav_input.h"

#include "record_check.h"

enum { RECORDS_MOST = 210 /* a satellite mask full of ones */ };

/* What a message gave; only the text of `satellite` and constants are pointed to. */
static struct {
	int n;
	struct {
		fw_kind kind;
		fw_any_record record;
	} list[RECORDS_MOST];
} first, second, *taken;

static void take(void *context, fw_kind kind, const void *record)
{
	record_check(context, kind, record);
	require(taken->n < RECORDS_MOST);
	fw_record_clear(kind, &taken->list[taken->n].record);
	memcpy(&taken->list[taken->n].record, record, fw_record_type_of(kind)->size);
	taken->list[taken->n++].kind = kind;
}

size_t fuzz_make(fw_random *random, uint8_t *data)
{
	const size_t n = 1 + (size_t)fw_random_below(random, 10);
	for (size_t i = 0; i < n; i++)
		nav_random_message(random, data + i * FW_SBAS_BYTES);
	return n * FW_SBAS_BYTES;
}

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t max, unsigned seed)
{
	static const uint8_t preambles[] = {0x53, 0x9a, 0xc6, 0x53};
	size = LLVMFuzzerMutate(data, size, max);
	for (size_t at = 0; (seed & 1) != 0 && at + FW_SBAS_BYTES <= size; at += FW_SBAS_BYTES) {
		data[at] = preambles[data[at] & 3];
		fw_sbas_finish(data + at);
	}
	return size;
}

static void encode_again(unsigned type, const fw_record_head *stamp)
{
	uint8_t message[FW_SBAS_BYTES];
	require(fw_sbas_begin(type, 0, message) == FW_OK);
	for (int i = 0; i < first.n; i++)
		if (fw_sbas_add(first.list[i].kind, &first.list[i].record, message) != FW_OK)
			return; /* a message that says a thing twice, or what no record can ask for */
	fw_sbas_finish(message);
	second.n = 0;
	taken = &second;
	require(fw_sbas_decode(message, "S123", stamp, (fw_sink){take, NULL}) == FW_OK);
	require(second.n >= first.n);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
	const fw_record_head stamp = {3, SBF_WEEK, 345600};
	for (size_t at = 0; at + FW_SBAS_BYTES <= size; at += FW_SBAS_BYTES) {
		first.n = 0;
		taken = &first;
		if (fw_sbas_decode(data + at, "S123", &stamp, (fw_sink){take, NULL}) == FW_OK && first.n > 0)
			encode_again(data[at + 1] >> 2, &stamp);
	}
	return 0;
}
