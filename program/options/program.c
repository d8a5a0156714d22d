// SPDX-License-Identifier: MIT
#include "program/options/program.h"

#include "program/options/options.h"
#include "program/options/tool.h"

#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/// Commands that only stipple-lab has.
static const char* const lab_commands[] = {"bench",        "capture", "compare-splats", "decimate",
                                           "distribution", "kernels", "scan",           "scene"};

const program* program_get(void)
{
    static const command* const no_commands[] = {NULL};
    static const program none = {.name = "stipple", .commands = no_commands};
    const program* running = tool_settings_get()->program;
    return running != NULL ? running : &none;
}

const command* const* commands(void)
{
    return program_get()->commands;
}

bool program_is_scene(const char* input)
{
    return strncmp(input, SCENE_PREFIX, strlen(SCENE_PREFIX)) == 0;
}

stp_result program_make_scene(stp_scene* scene, const char* input, void* user)
{
    const program* running = program_get();
    if (running->make_scene == NULL) {
        return stp_fail(scene->context, STP_ERROR_ARGUMENT,
                        "%s: named scenes are made by stipple-lab, not by %s", input,
                        running->name);
    }
    return running->make_scene(scene, input, user);
}

const command* tool_find_command(const char* name)
{
    for (const command* const* c = commands(); *c != NULL; ++c) {
        if (strcmp((*c)->name, name) == 0) {
            return *c;
        }
    }
    return NULL;
}

static int fail_unknown_command(const char* name)
{
    for (size_t i = 0; i < sizeof(lab_commands) / sizeof(lab_commands[0]); ++i) {
        if (strcmp(name, lab_commands[i]) == 0) {
            return tool_usage_error("stipple-lab has the command '%s'", name);
        }
    }
    const char* best = NULL;
    unsigned distance = 3;
    for (const command* const* c = commands(); *c != NULL; ++c) {
        unsigned d = options_word_distance(name, (*c)->name);
        if (d < distance) {
            best = (*c)->name;
            distance = d;
        }
    }
    if (best != NULL) {
        return tool_usage_error("unknown command '%s'; did you mean '%s'?", name, best);
    }
    return tool_usage_error("unknown command '%s'", name);
}

static void print_version(void)
{
    printf("%s %s\n", program_get()->name, STP_VERSION);
}

// Options before the command: the common ones only.
static int run_without_command(int argc, char** argv)
{
    int code = options_parse(NULL, &argc, argv);
    if (code != 0) {
        return code;
    }
    const tool_settings* settings = tool_settings_get();
    if (settings->version) {
        print_version();
        return 0;
    }
    bool asked = settings->help || settings->help_all;
    help_print_overview(asked ? stdout : stderr);
    return asked ? 0 : 2;
}

static int run_command(const command* c, int argc, char** argv)
{
    tool_settings* settings = tool_settings_get();
    settings->command = c->name;
    int code = options_parse(c->options != NULL ? c->options() : NULL, &argc, argv);
    if (code != 0) {
        return code;
    }
    if (settings->help || settings->help_all) {
        help_print_command(stdout, c, settings->help_all);
        return 0;
    }
    if (settings->version) {
        print_version();
        return 0;
    }
    code = c->run(argc, argv);
    tool_end_progress();
    return tool_finish_interrupted(code, c->interrupted);
}

/// Files are memory-mapped: if another program shortens one, its pages disappear.
static void end_without_file(int number)
{
    static const char message[] =
        ": a file in use was truncated by another program, or its disk failed\n";
    const char* name = program_get()->name;
    (void)number;
    bool written = write(STDERR_FILENO, name, strlen(name)) >= 0 &&
                   write(STDERR_FILENO, message, sizeof(message) - 1) >= 0;
    _exit(written ? 1 : 2);
}

/// Keeps the arguments as given; commands reorder theirs.
static bool keep_arguments(int argc, char** argv)
{
    size_t size = ((size_t)argc + 1) * sizeof(*argv);
    char** copy = malloc(size);
    if (copy != NULL) {
        memcpy(copy, argv, size);
    }
    tool_settings_get()->arguments = copy;
    return copy != NULL;
}

int program_main(const program* self, int argc, char** argv)
{
    tool_settings_get()->program = self;
    if (!keep_arguments(argc, argv)) {
        return tool_error("out of memory");
    }
    (void)signal(SIGPIPE, SIG_IGN); // a closed pipe is a failed write, with a message
    (void)signal(SIGXFSZ, SIG_IGN); // so is a file that reached its size limit
    (void)signal(SIGBUS, end_without_file);
    int first = 1;
    while (first < argc && argv[first][0] == '-') {
        first += 1;
    }
    int code = 2;
    if (first >= argc) {
        code = run_without_command(argc - 1, argv + 1);
    } else {
        // "stipple -q build ..." is "stipple build -q ..."
        char* name = argv[first];
        memmove(argv + 2, argv + 1, (size_t)(first - 1) * sizeof(*argv));
        const command* found = tool_find_command(name);
        code = found != NULL ? run_command(found, argc - 2, argv + 2) : fail_unknown_command(name);
    }
    return tool_finish_output(code);
}
