// SPDX-License-Identifier: MIT
// Which file a reference names. A model may name files in its own folder and below, nothing else.
#define _XOPEN_SOURCE 700 // realpath
#include "import/import.h"

#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#define REFERENCE_LENGTH_LIMIT ((size_t)4096)

static bool is_letter(char c)
{
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
}

static bool is_separator(char c)
{
    return c == '/' || c == '\\'; // files written on Windows have the latter
}

// "C:", "file:", "https:": letters, digits, "+", "-", "." up to a colon (RFC 3986, 3.1).
static bool has_scheme(const char* text)
{
    if (!is_letter(*text)) {
        return false;
    }
    while (is_letter(*text) || (*text >= '0' && *text <= '9') || *text == '+' || *text == '-' ||
           *text == '.') {
        text += 1;
    }
    return *text == ':';
}

// Writes the folder and the reference without "." and "..", so that no link in between can change
// what
// ".." means; `out` has room for both and two bytes more. NULL, or the reason for a refusal.
static const char* join(const char* folder, size_t folder_length, const char* reference, char* out)
{
    memcpy(out, folder, folder_length);
    char* start = out + folder_length;
    char* end = start;
    for (const char* at = reference; *at != '\0';) {
        size_t length = 0;
        while (at[length] != '\0' && !is_separator(at[length])) {
            if ((unsigned char)at[length] < 0x20) {
                return "it has a control character";
            }
            length += 1;
        }
        if (length == 2 && at[0] == '.' && at[1] == '.') {
            if (end == start) {
                return "it leaves the folder of the file";
            }
            do {
                end -= 1;
            } while (end > start && *end != '/');
        } else if (length != 0 && !(length == 1 && at[0] == '.')) {
            if (end > start) {
                *end++ = '/';
            }
            memcpy(end, at, length);
            end += length;
        }
        at += length + (at[length] != '\0');
    }
    *end = '\0';
    return end == start ? "it names no file" : NULL;
}

// Whether a file is, links followed, in a folder (its path up to the last slash; empty: the current one) or below.
// What does not exist is where it seems to be.
static bool is_below(const char* path, size_t folder_length)
{
    char folder[PATH_MAX];
    if (folder_length >= sizeof(folder)) {
        return false;
    }
    memcpy(folder, path, folder_length);
    folder[folder_length] = '\0';
    char* real_folder = realpath(folder_length != 0 ? folder : ".", NULL);
    char* real_path = realpath(path, NULL);
    size_t length = real_folder != NULL ? strlen(real_folder) : 0;
    bool root = length == 1;
    bool below =
        real_path == NULL || (length != 0 && strncmp(real_path, real_folder, length) == 0 &&
                              (root || real_path[length] == '/'));
    free(real_folder);
    free(real_path);
    return below;
}

// On STP_OK either *path or *reason is set.
static stp_result resolve(stp_import* import, const char* reference, const char** path,
                          const char** reason)
{
    *path = NULL;
    *reason = NULL;
    size_t length = strlen(reference);
    if (import->alone) {
        *reason = "the model was read from memory";
    } else if (length > REFERENCE_LENGTH_LIMIT) {
        *reason = "it is too long";
    } else if (is_separator(reference[0])) {
        *reason = "it is an absolute path";
    } else if (has_scheme(reference)) {
        *reason = "it has a drive letter or is a URL";
    }
    if (*reason != NULL) {
        return STP_OK;
    }
    const char* slash = strrchr(import->path, '/');
    size_t folder_length = slash != NULL ? (size_t)(slash + 1 - import->path) : 0;
    char* joined = stp_arena_alloc(&import->scene->text, folder_length + length + 2);
    if (joined == NULL) {
        return stp_fail_memory(import->context);
    }
    *reason = join(import->path, folder_length, reference, joined);
    if (*reason == NULL && !is_below(joined, folder_length)) {
        *reason = "it is a link out of the folder of the file";
    }
    *path = *reason == NULL ? joined : NULL;
    return STP_OK;
}

stp_result stp_import_resolve(stp_import* import, const char* reference, const char** path)
{
    const char* reason;
    stp_result result = resolve(import, reference, path, &reason);
    if (result == STP_OK && *path == NULL) {
        return stp_fail(import->context, STP_ERROR_FORMAT,
                        "%s: the reference \"%.200s\" is refused: %s", import->path, reference,
                        reason);
    }
    return result;
}

stp_result stp_import_resolve_optional(stp_import* import, const char* place, const char* reference,
                                       const char** path)
{
    const char* reason;
    stp_result result = resolve(import, reference, path, &reason);
    if (result != STP_OK) {
        return result;
    }
    struct stat status;
    if (*path != NULL && (stat(*path, &status) != 0 || !S_ISREG(status.st_mode))) {
        reason = "there is no such file";
        *path = NULL;
    }
    if (*path == NULL) {
        stp_warn(import->context, "%s: %s: \"%.200s\" is left out: %s", import->path, place,
                 reference, reason);
    }
    return STP_OK;
}
