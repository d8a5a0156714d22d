// SPDX-License-Identifier: MIT
//
// stipple-lab: the commands of stipple, those for measuring and for the papers, and named scenes.
// The same file is the main function of its viewer, stipple-lab-view.
#include "lab/scenes/scenes.h"
#include "program/options/program.h"

#define COMMAND(name) extern const command command_##name;
#include "lab_command_list.h"
#undef COMMAND

static const command* const list[] = {
#define COMMAND(name) &command_##name,
#include "lab_command_list.h"
#undef COMMAND
    NULL,
};

int main(int argc, char** argv)
{
    static const program self = {.name = "stipple-lab",
                                 .commands = list,
                                 .is_lab = true,
                                 .make_scene = scene_make_input,
                                 .scenes_version = SCENES_VERSION};
    return program_main(&self, argc, argv);
}
