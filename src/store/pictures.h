// SPDX-License-Identifier: MIT
// Textures inside a store: their blocks hold texels, or a picture file (PNG, JPEG, WebP) that several may share.
#pragma once

#include "image/image.h"
#include "store/internal.h"
#include "store/writer.h"

/// Checks a picture's header against its texture: kind and size. `info` gets what decoding needs, or the reason.
STP_MUST_USE stp_result stp_store_measure_picture(const stp_store_texture* texture,
                                                  const unsigned char* bytes, size_t size,
                                                  stp_image_info* info);

/// Whether a file of so many bytes may hold pictures of so many texels in all.
bool stp_store_believes_texels(uint64_t texels, uint64_t file_bytes);

/// For each texture of `content`, the first that is the same picture file: they share a block. Others: itself.
STP_MUST_USE stp_result stp_store_find_texture_owners(stp_context* context,
                                                      const stp_store_content* content,
                                                      uint32_t* owners);

/// What the reader would refuse of the pictures of `content`.
STP_MUST_USE stp_result stp_store_judge_pictures(const stp_store_judge* judge,
                                                 const stp_store_content* content);

/// The same of an open file's records, and fits them to their blocks.
STP_MUST_USE stp_result stp_store_link_textures(stp_store* store);

/// How many textures have a block of their own.
uint32_t stp_store_count_texture_blocks(const stp_store* store);

/// Frees all decoded texels; they can be decoded again.
void stp_store_release_textures(stp_store* store);
