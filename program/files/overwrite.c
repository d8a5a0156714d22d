// SPDX-License-Identifier: MIT
#include "program/files/overwrite.h"

#include "base/io/file.h"
#include "program/options/tool.h"

#include <assert.h>
#include <dirent.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>

enum { SEARCHED_BYTES = 1 << 24 }; ///< bytes of a file that are searched for another's name

static const char* base_name(const char* path)
{
    const char* slash = strrchr(path, '/');
    return slash != NULL ? slash + 1 : path;
}

// The folder of a path, "." if it has none. @return false if it is too long
static bool folder_of(const char* path, char folder[PATH_MAX])
{
    size_t length = (size_t)(base_name(path) - path);
    if (length >= PATH_MAX) {
        return false;
    }
    assert(length == 0 || path[length - 1] == '/');
    memcpy(folder, length > 0 ? path : ".", length > 0 ? length : 1);
    folder[length > 0 ? length : 1] = '\0';
    return true;
}

static bool file_contains(const char* path, const char* name)
{
    char* bytes = malloc(SEARCHED_BYTES);
    size_t size = bytes != NULL ? stp_file_peek(path, bytes, SEARCHED_BYTES) : 0;
    size_t length = strlen(name);
    bool found = false;
    for (size_t at = 0; !found && at + length <= size; ++at) {
        found = bytes[at] == name[0] && memcmp(bytes + at, name, length) == 0;
    }
    free(bytes);
    return found;
}

static bool has_suffix(const char* path, const char* suffix)
{
    const char* dot = strrchr(base_name(path), '.');
    return dot != NULL && strcasecmp(dot, suffix) == 0;
}

// An OBJ names material libraries, and those name pictures.
static bool library_contains(const char* folder, const char* name)
{
    DIR* listing = opendir(folder);
    bool found = false;
    for (struct dirent* entry; listing != NULL && !found && (entry = readdir(listing)) != NULL;) {
        char path[PATH_MAX + 260];
        snprintf(path, sizeof(path), "%s/%s", folder, entry->d_name);
        found = has_suffix(entry->d_name, ".mtl") && file_contains(path, name);
    }
    if (listing != NULL) {
        closedir(listing);
    }
    return found;
}

static bool names_file(const char* input, const char* output)
{
    char folders[2][PATH_MAX];
    struct stat status;
    bool text =
        has_suffix(input, ".gltf") || has_suffix(input, ".obj") || has_suffix(input, ".dae");
    if (!text || stat(output, &status) != 0 || !S_ISREG(status.st_mode) ||
        !folder_of(input, folders[0]) || !folder_of(output, folders[1]) ||
        !tool_is_same_file(folders[0], folders[1])) {
        return false;
    }
    const char* name = base_name(output);
    return file_contains(input, name) ||
           (has_suffix(input, ".obj") && library_contains(folders[0], name));
}

int overwrite_check(const char* input, const char* output)
{
    if (input == NULL || output == NULL) {
        return 0;
    }
    if (tool_is_same_file(input, output)) {
        return tool_usage_error("%s is an input and would be overwritten", output);
    }
    return names_file(input, output)
               ? tool_usage_error("%s is a part of %s and would be overwritten", output, input)
               : 0;
}
