// SPDX-License-Identifier: MIT
// CRC-32C (Castagnoli), used for the pages of E57 files.
#pragma once

#include <stddef.h>
#include <stdint.h>

/// Checksum of `size` bytes: reflected, initial value and final XOR all ones. Any thread.
uint32_t stp_crc32c(const void* bytes, size_t size);

/// Portable variant; stp_crc32c chooses.
uint32_t stp_crc32c_portable(const void* bytes, size_t size);
/// Variant with the CPU's CRC instruction. Requires AVX2 or more from stp_processor_detect.
uint32_t stp_crc32c_avx2(const void* bytes, size_t size);
