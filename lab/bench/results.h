// SPDX-License-Identifier: MIT
// Results of measurements: a list of {name, params, figures}, printed with the machine.
#pragma once

#include <jansson.h>
#include <stddef.h>
#include <stdint.h>

typedef struct bench_entry {
    json_t* params;  ///< borrowed
    json_t* figures; ///< borrowed
} bench_entry;
/// Adds {name, params: {}, figures: {}} to the results.
bench_entry bench_result(json_t* results, const char* name);

void bench_set_count(json_t* object, const char* key, uint64_t value);
void bench_set_number(json_t* object, const char* key, double value);
void bench_set_text(json_t* object, const char* key, const char* value);

/// Sorts the values and returns the middle one (the lower of two); 0 if there are none.
double bench_median(double* values, size_t count);

// Both print the machine and the results, free the results, and return the exit code.
int bench_print_json(json_t* results);
int bench_print_text(json_t* results);
