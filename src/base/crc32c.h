// SPDX-License-Identifier: MIT
// CRC-32C (Castagnoli), as E57 files have it of each page.
#pragma once

#include <stddef.h>
#include <stdint.h>

/// The checksum of `size` bytes: reflected, from and to all ones. Any thread.
uint32_t stp_crc32c(const void* bytes, size_t size);

/// The same in portable C; stp_crc32c chooses.
uint32_t stp_crc32c_portable(const void* bytes, size_t size);
/// The same by the processor's own instruction. Only where stp_processor_detect says AVX2 or more.
uint32_t stp_crc32c_avx2(const void* bytes, size_t size);
