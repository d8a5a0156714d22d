// SPDX-License-Identifier: MIT
// Shared by the files that read and write viewpoints; and the JSON parser, which flights use too.
#pragma once

#include "base/core/context.h"
#include "program/present/viewpoints.h"

#include <jansson.h>

void stp_viewpoint_destroy(stp_context* context, stp_viewpoint* view);

/// Appends a viewpoint and, on success, takes ownership of its texts and arrays.
/// @return STP_OK, STP_ERROR_LIMIT, STP_ERROR_OUT_OF_MEMORY; logged
STP_MUST_USE stp_result stp_viewpoints_add(stp_context* context, stp_viewpoints* viewpoints,
                                           stp_viewpoint* added);

/// The lists of objects in the file, by stp_shown_as.
static const char* const stp_viewpoint_lists[] = {"hidden", "isolated", "ghosts", "focused"};

// Parses JSON of files that people may write by hand (jansson), within the memory limit.

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
