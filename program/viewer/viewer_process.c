// SPDX-License-Identifier: MIT
//
// The viewer is an executable of its own, `stipple-view` or `stipple-lab-view`, so that other
// commands do not load the window system's libraries, which takes longer than many commands run.
// `view` becomes that executable: it consists of the same commands, and parses the same arguments.
#include "program/options/program.h"
#include "program/options/tool.h"
#include "program/viewer/panels/viewer.h"

#include <assert.h>
#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

/// Path of the executable's folder with the separator at the end. @return its length, 0 if unknown
static size_t find_folder(char* path, size_t size)
{
    ssize_t length = readlink("/proc/self/exe", path, size - 1);
    size_t end = length > 0 ? (size_t)length : 0;
    while (end > 0 && path[end - 1] != '/') {
        end -= 1;
    }
    return end;
}

int viewer_run(const viewer_options* options)
{
    (void)options; // the viewer reads them from the arguments
    // in a build folder, and installed
    static const char* const places[] = {"", "../libexec/stipple/"};
    char path[PATH_MAX + 64] = "";
    size_t folder = find_folder(path, PATH_MAX);
    int code = ENOENT;
    for (size_t i = 0; i < 2 && code == ENOENT; ++i) {
        snprintf(path + folder, sizeof(path) - folder, "%s%s-view", places[i], program_get()->name);
        (void)execv(path, tool_settings_get()->arguments);
        code = errno; // only after a failure
    }
    return tool_error("cannot start the viewer %s: %s", path, strerror(code));
}
