// SPDX-License-Identifier: MIT
#pragma once

#include "embed/builder.h"

/// For stp_build_desc.generate: `user` is the builder, whose geometry is gone afterwards. @return STP_OK,
/// STP_ERROR_OUT_OF_MEMORY, STP_ERROR_IO (a second call, or the spill); logged
STP_MUST_USE stp_result stp_builder_move(stp_scene* scene, const char* input, void* user);
