// SPDX-License-Identifier: MIT
#include "present/json_text.h"

#define PARSED_BYTES 64 // parser memory per byte of text, for text full of numbers

stp_result stp_json_parse(stp_context* context, const char* name, const unsigned char* bytes,
                          size_t size, json_t** root)
{
    *root = NULL;
    uint64_t parsed = (uint64_t)size * PARSED_BYTES;
    if (!stp_reserve(context, parsed)) {
        return stp_fail_memory(context);
    }
    json_error_t error;
    *root = json_loadb(size > 0 ? (const char*)bytes : "", size, JSON_REJECT_DUPLICATES, &error);
    if (*root != NULL) {
        return STP_OK;
    }
    stp_release(context, parsed);
    if (json_error_code(&error) == json_error_out_of_memory) {
        return stp_fail_memory(context);
    }
    return stp_fail(context, STP_ERROR_FORMAT, "%s: line %d: not JSON: %s", name, error.line,
                    error.text);
}

void stp_json_release(stp_context* context, json_t* root, size_t size)
{
    json_decref(root);
    stp_release(context, (uint64_t)size * PARSED_BYTES);
}
