// SPDX-License-Identifier: MIT
//
// stipple help: prints the command tables as text, man page or shell completion.
#include "program/options/tool.h"

static struct {
    bool man, all;
    int completion;
    bool completion_given;
} args;

static const option* options(void)
{
    static const option table[] = {
        {.name = "all",
         .help = "list all options of the command, not only the usual ones",
         .value = &args.all},
        {.name = "man",
         .help = "print the mdoc(7) man page of the command, or of the whole tool",
         .value = &args.man},
        {.name = "completion",
         .type = OPTION_CHOICE,
         .argument = "SHELL",
         .words = "bash|zsh|fish",
         .help = "print the completions for a shell",
         .value = &args.completion,
         .given = &args.completion_given},
        {0},
    };
    return table;
}

static int run(int argc, char** argv)
{
    static void (*const print_completion[])(FILE*) = {completion_print_bash, completion_print_zsh,
                                                      completion_print_fish};
    if (argc > 1) {
        return tool_usage_error("help explains one command at a time");
    }
    const command* found = argc == 1 ? tool_find_command(argv[0]) : NULL;
    if (argc == 1 && found == NULL) {
        return tool_usage_error("unknown command '%s'", argv[0]);
    }
    if (args.completion_given) {
        print_completion[args.completion](stdout);
    } else if (args.man) {
        manual_print(stdout, found);
    } else if (found != NULL) {
        help_print_command(stdout, found, args.all);
    } else {
        help_print_overview(stdout);
    }
    return 0;
}

const command command_help = {
    .name = "help",
    .arguments = "[COMMAND]",
    .summary = "explain a command, or list all commands",
    .text = "Without a command, lists all commands. 'stipple help NAME' lists the usual options of "
            "a command, with --all every option. It also prints man pages and shell "
            "completions:\n\n"
            "  stipple help --man render | man -l -\n"
            "  source <(stipple help --completion bash)",
    .examples = "Read a man page:\n"
                "$ stipple help --man render | man -l -\n"
                "Enable completions in this shell:\n"
                "$ source <(stipple help --completion bash)\n",
    .files = "~/.local/share/bash-completion/completions/stipple\t"
             "where bash looks for completions\n",
    .options = options,
    .run = run,
};
