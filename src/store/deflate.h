// SPDX-License-Identifier: MIT
//
// Pieces of a file that are compressed alone: chunks of octaves and pages of the directory. A piece that is stored in
// fewer bytes than its content is a DEFLATE stream, followed by zero bytes up to a part of the content's size.
#pragma once

#include <stdbool.h>
#include <stddef.h>

enum {
    STP_STORE_PIECE_BYTES = 1 << 16, ///< most of a piece, decoded
    STP_STORE_PIECE_ENTRY = 8,       ///< bytes of an entry of a table of pieces: size, checksum
    STP_STORE_PIECE_RATIO = 32,      ///< no piece is stored in less than this part of its size
};

/// A compressor, for one thread at a time; takes about 300 KiB.
typedef struct libdeflate_compressor stp_store_packer;
/// NULL where memory runs out.
stp_store_packer* stp_store_packer_create(void);
void stp_store_packer_destroy(stp_store_packer* packer);
/// Compresses a piece into `out`, which has room for `size` bytes; as it is where `packer` is NULL. @return the bytes
/// stored, at most `size`
size_t stp_store_pack(stp_store_packer* packer, const void* bytes, size_t size, void* out);

/// A decompressor, for one thread at a time; takes about 12 KiB.
typedef struct libdeflate_decompressor stp_store_unpacker;
void stp_store_unpacker_destroy(stp_store_unpacker* unpacker);
/// Decodes a piece of `size` bytes that is stored in fewer. `*unpacker` is made where it is NULL.
/// @return false where the bytes are no such piece, or memory runs out
bool stp_store_unpack(stp_store_unpacker** unpacker, const unsigned char* stored,
                      size_t stored_size, void* out, size_t size);
