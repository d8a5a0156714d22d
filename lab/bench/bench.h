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
    uint32_t count;    ///< positions, runs or points; 0: the benchmark's default
    uint32_t first;    ///< positions to skip, so that a measurement can be split into parts
    double splat_size; ///< diameter of splats in pictures of scenes, pixels
    uint32_t method;   ///< STP_METHOD_* that draws scenes; 0: the file's first
    bool all_sizes;    ///< no splat size was given: compare several
    bool has_eye;      ///< draw only the view from `eye` to `target`
    stp_vec3d eye, target;
    uint32_t size[2]; ///< width and height of pictures of scenes; 0: the benchmark's own
    uint32_t threads; ///< worker threads; 0: the benchmark's default, mostly all processors
    /// Memory limit in bytes under which scenes are loaded during drawing (gl: GPU memory); 0: the
    /// file is mapped
    uint64_t memory;
    bool uses_gl;         ///< spt: draw with OpenGL, not on the CPU
    const char* markdown; ///< path of a Markdown table (backends, gl); NULL: none
} bench_options;

typedef struct benchmark {
    const char* name;
    const char* summary; ///< one line, as `stipple-lab bench --list` prints it
    /// Adds its results (bench_result); returns the exit code: 0, or 1 with the message printed.
    int (*run)(const bench_options* options, json_t* results);
} benchmark;

/// All benchmarks, NULL at the end.
const benchmark* const* benchmarks(void);
