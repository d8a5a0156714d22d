// SPDX-License-Identifier: MIT
#include "support_boxes.h"

#include "tests.h"

#include "builder/build_scene.h"
#include "lab/scenes/scenes.h"

#include <stdio.h>
#include <unistd.h>

bool boxes_build(const char* name, char path[64])
{
    const char* input = "scene:boxes";
    snprintf(path, 64, "stp_%s_%ld.stip", name, (long)getpid());
    stp_context* context = test_context(NULL, 1, NULL);
    stp_build_desc desc = {
        .inputs = &input, .input_count = 1, .output = path, .generate = scene_make_input};
    stp_build_report report;
    bool built = stp_build(context, &desc, &report) == STP_OK;
    stp_context_destroy(context);
    return built;
}
