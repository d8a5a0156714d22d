// SPDX-License-Identifier: MIT
// Parses JSON of files that people may write by hand (jansson), within the memory limit.
#pragma once

#include "base/core/context.h"

#include <jansson.h>

typedef struct stp_json_text {
    const char* name; ///< begins error messages
    const char* kind; ///< what it is, for error messages: "a flight"
    const unsigned char* bytes;
    size_t size, size_limit;
} stp_json_text;

/// Counts jansson's own allocations as a multiple of the text's size.
/// @param root  release with stp_json_release
/// @return STP_OK, STP_ERROR_FORMAT, STP_ERROR_LIMIT, STP_ERROR_OUT_OF_MEMORY; logged
STP_MUST_USE stp_result stp_json_parse(stp_context* context, const stp_json_text* text,
                                       json_t** root);
void stp_json_release(stp_context* context, const stp_json_text* text, json_t* root);

/// Reads an array of exactly `count` numbers, none beyond `maximum` in size. False if it is not
/// one.
bool stp_json_numbers(const json_t* json, size_t count, double maximum, double* numbers);
