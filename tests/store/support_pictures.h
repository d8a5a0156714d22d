// SPDX-License-Identifier: MIT
// Textures whose blocks are image files.
#pragma once

#include "support_sample.h"

enum { PICTURE_SIZE = 16, PICTURE_TEXTURES = 5 };

/// The textures. PICTURE_AGAIN is PICTURE_PNG with another wrap mode.
enum { PICTURE_PNG, PICTURE_AGAIN, PICTURE_JPEG, PICTURE_WEBP, PICTURE_TEXELS };

/// Replaces the sample's textures by five of PICTURE_SIZE times `large` on each side, in the
/// arena's memory. False if that runs out.
bool pictures_add(stp_arena* arena, sample* made, uint32_t large);

/// The expected texels of a texture: the same for all; the JPEG picture is only close to them.
uint8_t pictures_value(uint32_t x, uint32_t y, uint32_t channel);

/// The largest difference between a texture's texels and the expected ones.
int pictures_error(const stp_store_texture* texture);
