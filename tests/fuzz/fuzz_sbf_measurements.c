/* MeasEpoch and MeasExtra. What one MeasEpoch gave makes another that gives as much. */
#include "sbf_input.h"

#include "formats/sbf_measurements.h"

#include "record_check.h"

enum { MEAS_EXTRA = 4000, MEAS_EPOCH = 4027, OBS_MOST = FUZZ_ROOM / 12 };

static fw_sbf_channels channels;
static furrow_epoch epoch;
static furrow_obs obs[OBS_MOST];
static unsigned n_epochs, n_obs;

static size_t make(fw_random *r, uint32_t *tow_ms, uint8_t *blocks)
{
	const size_t n = sbf_make_by_table(r, fw_sbf_schema_find(MEAS_EPOCH), *tow_ms, blocks);
	if (fw_random_below(r, 2) == 0)
		return n;
	return n + sbf_make_by_table(r, fw_sbf_schema_find(MEAS_EXTRA), *tow_ms, blocks + n);
}

size_t fuzz_make(fw_random *random, uint8_t *data)
{
	return sbf_make_stream(random, make, data, FUZZ_ROOM);
}

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t max, unsigned seed)
{
	return sbf_mutate(data, size, max, seed, make);
}

static void take(void *context, fw_kind kind, const void *record)
{
	record_check(context, kind, record);
	if (kind == FW_epoch) {
		epoch = *(const furrow_epoch *)record;
		n_epochs++;
	} else if (kind == FW_obs) {
		require(n_obs < OBS_MOST);
		obs[n_obs++] = *(const furrow_obs *)record;
	}
}

static void decode_epoch(const uint8_t *block, uint16_t length)
{
	fw_sbf_left_out left_out = {0};
	fw_kind_set wanted = {{0}};
	fw_kind_add(&wanted, FW_epoch);
	fw_kind_add(&wanted, FW_obs);
	n_epochs = n_obs = 0;
	fw_sbf_meas_epoch(block, length, FW_ANTENNA_ALL, &wanted, (fw_sink){take, NULL}, &channels,
	                  &left_out);
	require(n_epochs <= 1);
}

static void encode_again(void)
{
	static uint8_t block[FW_SBF_MAX_LENGTH];
	uint16_t length;
	const unsigned n = n_obs;
	if (n_epochs == 0 || fw_sbf_encode_meas_epoch(&epoch, obs, n, block, &length) != FW_OK)
		return;
	require(fw_load_u16(block + 2) == fw_crc16(block + 4, length - 4U));
	decode_epoch(block, length);
	require(n_obs == n);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
	memset(&channels, 0, sizeof channels);
	for (size_t at = 0; (at = sbf_find(data, size, at)) + FW_SBF_HEADER <= size;) {
		const uint16_t id = fw_load_u16(data + at + 4) & 0x1fff, length = fw_load_u16(data + at + 6);
		if (length < FW_SBF_HEADER || length > FW_SBF_MAX_LENGTH || length > size - at) {
			at += 2;
			continue;
		}
		const uint8_t *const block = sbf_alone(data + at, length);
		if (id == MEAS_EXTRA) {
			fw_sbf_meas_extra(block, length, FW_ANTENNA_ALL, &channels,
			                  (fw_sink){record_check, NULL});
		} else if (id == MEAS_EPOCH) {
			decode_epoch(block, length);
			encode_again();
		}
		at += length;
	}
	return 0;
}
