/* Little-endian loads and stores at any address; compilers make one instruction of each. */
#ifndef FURROW_FORMATS_BYTES_H
#define FURROW_FORMATS_BYTES_H

#include <stdint.h>
#include <string.h>

static inline uint16_t fw_load_u16(const uint8_t *p)
{
	return (uint16_t)(p[0] | p[1] << 8);
}

static inline uint32_t fw_load_u32(const uint8_t *p)
{
	return (uint32_t)p[0] | (uint32_t)p[1] << 8 | (uint32_t)p[2] << 16 | (uint32_t)p[3] << 24;
}

static inline uint64_t fw_load_u64(const uint8_t *p)
{
	return (uint64_t)fw_load_u32(p) | (uint64_t)fw_load_u32(p + 4) << 32;
}

static inline float fw_load_f32(const uint8_t *p)
{
	uint32_t bits = fw_load_u32(p);
	float x;
	memcpy(&x, &bits, sizeof x);
	return x;
}

static inline double fw_load_f64(const uint8_t *p)
{
	uint64_t bits = fw_load_u64(p);
	double x;
	memcpy(&x, &bits, sizeof x);
	return x;
}

static inline void fw_store_u16(uint8_t *p, uint16_t v)
{
	p[0] = (uint8_t)v;
	p[1] = (uint8_t)(v >> 8);
}

static inline void fw_store_u32(uint8_t *p, uint32_t v)
{
	fw_store_u16(p, (uint16_t)v);
	fw_store_u16(p + 2, (uint16_t)(v >> 16));
}

static inline void fw_store_u64(uint8_t *p, uint64_t v)
{
	fw_store_u32(p, (uint32_t)v);
	fw_store_u32(p + 4, (uint32_t)(v >> 32));
}

#endif
