// SPDX-License-Identifier: MIT
//
// stipple: the commands for users. The same file is the main function of its viewer, stipple-view.
#include "program/options/program.h"

#define COMMAND(name) extern const command command_##name;
#include "command_list.h"
#undef COMMAND

static const command* const list[] = {
#define COMMAND(name) &command_##name,
#include "command_list.h"
#undef COMMAND
    NULL,
};

int main(int argc, char** argv)
{
    static const program self = {.name = "stipple", .commands = list};
    return program_main(&self, argc, argv);
}
