// SPDX-License-Identifier: MIT
#include "program/present/viewpoints_internal.h"

#include <assert.h>
#include <math.h>

#define PARSED_BYTES 64 // parser memory per byte of text, for text full of numbers

stp_result stp_json_parse(stp_context* context, const stp_json_text* text, json_t** root)
{
    *root = NULL;
    if (text->size > text->size_limit) {
        return stp_fail(context, STP_ERROR_LIMIT, "%s: %s may have at most %zu bytes, this has %zu",
                        text->name, text->kind, text->size_limit, text->size);
    }
    uint64_t parsed = (uint64_t)text->size * PARSED_BYTES;
    if (!stp_reserve(context, parsed)) {
        return stp_fail_memory(context);
    }
    json_error_t error;
    *root = json_loadb(text->size > 0 ? (const char*)text->bytes : "", text->size,
                       JSON_REJECT_DUPLICATES, &error);
    if (*root != NULL) {
        return STP_OK;
    }
    stp_release(context, parsed);
    if (json_error_code(&error) == json_error_out_of_memory) {
        return stp_fail_memory(context);
    }
    return stp_fail(context, STP_ERROR_FORMAT, "%s: line %d: not JSON: %s", text->name, error.line,
                    error.text);
}

void stp_json_release(stp_context* context, const stp_json_text* text, json_t* root)
{
    assert(text->size <= text->size_limit && "nothing was reserved for a longer text");
    json_decref(root);
    stp_release(context, (uint64_t)text->size * PARSED_BYTES);
}

bool stp_json_numbers(const json_t* json, size_t count, double maximum, double* numbers)
{
    bool good = json_is_array(json) && json_array_size(json) == count;
    for (size_t i = 0; good && i < count; ++i) {
        const json_t* number = json_array_get(json, i);
        numbers[i] = json_number_value(number);
        good = json_is_number(number) && fabs(numbers[i]) <= maximum;
    }
    return good;
}
