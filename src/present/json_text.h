// SPDX-License-Identifier: MIT
// JSON texts of files that people may write by hand (jansson), within the limit of memory.
#pragma once

#include "base/context.h"

#include <jansson.h>

/// Counts what jansson allocates by itself, as a multiple of the text's size. `name` begins the message of a failure.
/// @param root  the caller's (stp_json_release with the same size)
/// @return STP_OK, STP_ERROR_FORMAT, STP_ERROR_OUT_OF_MEMORY; logged
STP_MUST_USE stp_result stp_json_parse(stp_context* context, const char* name,
                                       const unsigned char* bytes, size_t size, json_t** root);
void stp_json_release(stp_context* context, json_t* root, size_t size);
