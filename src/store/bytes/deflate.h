// SPDX-License-Identifier: MIT
//
// Separately compressed chunks of a file, of its blocks and of the pages of its directory. A chunk
// whose stored size is smaller than its content is a DEFLATE stream, padded with zero bytes to at
// least 1/STP_STORE_CHUNK_RATIO of that size. Every checksum of a file is a CRC-32.
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum {
    STP_STORE_CHUNK_BYTES = 1 << 16, ///< largest decoded chunk
    STP_STORE_CHUNK_ENTRY = 8,       ///< bytes of a table entry: size, checksum
    STP_STORE_CHUNK_RATIO = 32, ///< a stored chunk has at least this fraction of its decoded size
};

/// A compressor, for one thread at a time; takes about 300 KiB.
typedef struct libdeflate_compressor stp_store_packer;
/// NULL if memory runs out.
stp_store_packer* stp_store_packer_create(void);
void stp_store_packer_destroy(stp_store_packer* packer);
/// Compresses a chunk into `out`, which has room for `size` bytes; copies it if it does not shrink or
/// `packer` is NULL.
/// @return the bytes stored, at most `size`
size_t stp_store_pack(stp_store_packer* packer, const void* bytes, size_t size, void* out);

/// A decompressor and room for chunks, for one thread at a time; takes about 12 KiB, with the room
/// 204 KiB.
typedef struct stp_store_unpacker stp_store_unpacker;
void stp_store_unpacker_destroy(stp_store_unpacker* unpacker);
enum { STP_STORE_ROOMS = 3 };
/// Room for STP_STORE_ROOMS chunks, one after the other, aligned to 8 bytes: more than a small stack
/// has. Creates `*unpacker` if it is NULL. @return NULL if memory runs out
unsigned char* stp_store_unpacker_rooms(stp_store_unpacker** unpacker);
/// Decodes a chunk of `size` bytes whose stored size is smaller. Creates `*unpacker` if it is NULL.
/// @return false if the bytes are invalid, or memory runs out (`*unpacker` is NULL then)
bool stp_store_unpack(stp_store_unpacker** unpacker, const unsigned char* stored,
                      size_t stored_size, void* out, size_t size);

/// CRC-32 as zlib computes it. To chain calls, pass the previous value; start with 0.
uint32_t stp_store_crc(uint32_t crc, const void* bytes, size_t size);
