// SPDX-License-Identifier: MIT
//
// A benchmark is one file, bench_NAME.c, that defines `const benchmark benchmark_NAME`; CMake
// writes the list. It measures all alternatives interleaved, in one run, and reports medians.
#pragma once

#include "lab/bench/results.h"
#include "program/options/command.h"

#include <stipple/types.h>

typedef struct bench_options {
    bool quick;        ///< a small case of everything, within seconds
    const char* model; ///< a model to measure on; NULL: the benchmark's own
    uint32_t count;    ///< repetitions; 0: the benchmark's default
    uint32_t first;    ///< repetitions to skip, so that a measurement can be split into parts
    double splat_size; ///< of pictures of scenes
    uint32_t method;   ///< STP_METHOD_*, of pictures of scenes; 0: the file's first
    bool all_sizes;    ///< no size was given: all that are compared
    bool has_eye;
    stp_vec3d eye, target; ///< of the only picture, where `has_eye`
    uint32_t size[2];      ///< of pictures of scenes, pixels; 0: the benchmark's own
    uint32_t threads;      ///< that draw pictures of scenes, or build; 0: all
    /// Bytes under which scenes are loaded while they are drawn; 0: they are mapped
    uint64_t memory;
    bool uses_gl;         ///< of benchmarks that draw with either backend
    const char* markdown; ///< a file for a table of what is drawn by OpenGL; NULL: none
} bench_options;

typedef struct benchmark {
    const char* name;
    const char* summary; ///< one line, as `stipple bench --list` prints it
    /// Adds its results (bench_result); returns the exit code: 0, or 1 with the message printed.
    int (*run)(const bench_options* options, json_t* results);
} benchmark;

/// All benchmarks, NULL at the end.
const benchmark* const* benchmarks(void);
