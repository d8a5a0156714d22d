// SPDX-License-Identifier: MIT
#pragma once

#include "base/splats/octahedral.h"

/// stp_octahedral_encode_many for whole vectors of eight. @return how many were encoded
size_t stp_octahedral_encode_avx2(const float* normals, size_t count, int8_t* out);
