// SPDX-License-Identifier: MIT
#include "program/options/cue_names.h"

#include "program/options/command.h"

#include <string.h>

static const struct {
    const char* name;
    uint32_t bit;
} cues[] = {
    {"flatness", STP_CUE_FLATNESS_BIT},   {"edge", STP_CUE_EDGE_BIT},
    {"coverage", STP_CUE_COVERAGE_BIT},   {"silhouette", STP_CUE_SILHOUETTE_BIT},
    {"occlusion", STP_CUE_OCCLUSION_BIT}, {"error", STP_CUE_ERROR_BIT},
    {"specular", STP_CUE_SPECULAR_BIT},   {"importance", STP_CUE_IMPORTANCE_BIT},
};

/// 0: no cue has that name.
static uint32_t bit_of(const char* word, size_t length)
{
    for (size_t i = 0; i < sizeof(cues) / sizeof(cues[0]); ++i) {
        if (strlen(cues[i].name) == length && strncmp(cues[i].name, word, length) == 0) {
            return cues[i].bit;
        }
    }
    return 0;
}

bool cue_names_parse(const char* text, uint32_t* cues_off)
{
    *cues_off = 0;
    if (text == NULL) {
        return true;
    }
    *cues_off = STP_CUES_ALL;
    if (strcmp(text, "paper") == 0) {
        *cues_off &= ~(uint32_t)STP_CUES_PAPER;
        return true;
    }
    bool more = strcmp(text, "none") != 0;
    while (more) {
        size_t length = strcspn(text, ",");
        uint32_t bit = bit_of(text, length);
        if ((*cues_off & bit) == 0) {
            return false;
        }
        *cues_off &= ~bit;
        more = text[length] == ',';
        text += length + 1;
    }
    return true;
}

int cue_names_refuse(const char* text)
{
    return tool_usage_error("--cues must be a list of flatness, edge, coverage, silhouette, "
                            "occlusion, error, specular and importance, each at most once, or "
                            "paper, or none, not %s",
                            text);
}
