// SPDX-License-Identifier: MIT
// The cues of method `stochastic` as words: --cues.
#pragma once

#include "select/select.h"

#define OPTION_CUES(text)                                                                          \
    {                                                                                              \
        .name = "cues", .type = OPTION_TEXT, .argument = "NAME,...",                               \
        .help = "stochastic: cues that set the number of splats per region: flatness, edge, "      \
                "coverage, silhouette, occlusion, error (enough samples to cover, instead of "     \
                "the paper's counts), specular and importance (--splats N go where the view "      \
                "needs them); paper: the first five; none; default all",                           \
        .value = (text), .group = "Method stochastic", .rare = true                                \
    }

/// The cues that are not in a list. NULL: none are excluded; the list "none": all are. @return
/// false if a word is not a cue or is repeated
bool cue_names_parse(const char* text, uint32_t* cues_off);
/// Reports an invalid list. @return 2
int cue_names_refuse(const char* text);
