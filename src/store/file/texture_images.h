// SPDX-License-Identifier: MIT
// Textures of a store: their blocks hold texels or an image file (PNG, JPEG, WebP), which several
// textures can share.
#pragma once

#include "image/image_codecs.h"
#include "store/file/content.h"
#include "store/file/store_state.h"

/// Checks the header of an image file against its texture: format and size. `info` receives the
/// decoding parameters, or the reason for failure.
STP_MUST_USE stp_result stp_store_measure_picture(const stp_store_texture* texture,
                                                  const unsigned char* bytes, size_t size,
                                                  stp_image_info* info);

/// For each texture of `content`, the first one with the same image file: they share a block.
/// Others map to themselves.
STP_MUST_USE stp_result stp_store_find_texture_owners(stp_context* context,
                                                      const stp_store_content* content,
                                                      uint32_t* owners);

/// Checks the pictures of `content` as the reader would.
STP_MUST_USE stp_result stp_store_validate_pictures(const stp_store_validator* validator,
                                                    const stp_store_content* content);

/// Checks the texture records of an open file, and links them to their blocks.
STP_MUST_USE stp_result stp_store_link_textures(stp_store* store);

/// Number of textures that own their block.
uint32_t stp_store_count_texture_blocks(const stp_store* store);

/// Frees all decoded texels; they can be decoded again.
void stp_store_release_textures(stp_store* store);
