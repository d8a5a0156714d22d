// SPDX-License-Identifier: MIT
// Parses JSON of files that people may write by hand (jansson), within the memory limit.
#pragma once

#include "base/context.h"

#include <jansson.h>

/// Counts jansson's own allocations as a multiple of the text's size. `name` begins the error
/// message.
/// @param root  release with stp_json_release and the same size
/// @return STP_OK, STP_ERROR_FORMAT, STP_ERROR_OUT_OF_MEMORY; logged
STP_MUST_USE stp_result stp_json_parse(stp_context* context, const char* name,
                                       const unsigned char* bytes, size_t size, json_t** root);
void stp_json_release(stp_context* context, json_t* root, size_t size);
