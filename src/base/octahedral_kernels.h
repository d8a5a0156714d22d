// SPDX-License-Identifier: MIT
#pragma once

#include "base/octahedral.h"

/// stp_octahedral_encode_many of as many as fill whole vectors. @return how many
size_t stp_octahedral_encode_avx2(const float* normals, size_t count, int8_t* out);
