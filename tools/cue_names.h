// SPDX-License-Identifier: MIT
// The cues of method `stochastic` as words: --cues.
#pragma once

#include "select/select.h"

#define OPTION_CUES(text)                                                                          \
    {                                                                                              \
        .name = "cues", .type = OPTION_TEXT, .argument = "NAME,...",                               \
        .help = "stochastic: what the number of splats of a region is by, any of flatness, edge, " \
                "coverage, silhouette, occlusion, error (samples that cover, instead of the "      \
                "paper's numbers) and specular; paper: the first five; or none; default all",      \
        .value = (text)                                                                            \
    }

/// Those that are not in a list. NULL: none; all of the list "none". @return false where a word is no cue, or is there twice
bool cue_names_parse(const char* text, uint32_t* cues_off);
/// Says that a list is none. @return 2
int cue_names_refuse(const char* text);
