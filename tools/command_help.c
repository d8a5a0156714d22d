// SPDX-License-Identifier: MIT
#include "tool.h"

static const option* options(void)
{
    static const option table[] = {{0}};
    return table;
}

static int run(int argc, char** argv)
{
    if (argc > 1) {
        return tool_usage_error("help explains one command at a time");
    }
    if (argc == 0) {
        help_print_overview(stdout);
        return 0;
    }
    const command* found = tool_find_command(argv[0]);
    if (found == NULL) {
        return tool_usage_error("unknown command '%s'", argv[0]);
    }
    help_print_command(stdout, found);
    return 0;
}

const command command_help = {
    .name = "help",
    .arguments = "[COMMAND]",
    .summary = "explain a command, or list all",
    .text = "Without a command, lists all commands.",
    .options = options,
    .run = run,
};
