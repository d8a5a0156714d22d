// SPDX-License-Identifier: MIT
// Textures whose blocks are picture files.
#pragma once

#include "support_sample.h"

enum { PICTURE_SIZE = 16, PICTURE_TEXTURES = 5 };

/// Which texture is which: PICTURE_AGAIN is PICTURE_PNG with another wrap.
enum { PICTURE_PNG, PICTURE_AGAIN, PICTURE_JPEG, PICTURE_WEBP, PICTURE_TEXELS };

/// Replaces the sample's textures by five of PICTURE_SIZE, memory of the arena: false where that runs out. `large`
/// times that size on each side.
bool pictures_add(stp_arena* arena, sample* made, uint32_t large);

/// What a texture shows: the same for all but the JPEG picture, which is close to it.
uint8_t pictures_value(uint32_t x, uint32_t y, uint32_t channel);

/// The largest difference of a texture's texels from what it shows.
int pictures_error(const stp_store_texture* texture);
