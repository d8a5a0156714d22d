// SPDX-License-Identifier: MIT
#define _XOPEN_SOURCE 700 // realpath
#include "import/reading/path_rules.h"

#include <assert.h>
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

// Writes the folder and the reference without "." and "..", so that links cannot change the meaning
// of ".."; `out` has room for both plus two bytes. Returns NULL, or the reason for rejecting it.
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
        assert(end >= start && end - start <= at - reference);
    }
    *end = '\0';
    return end == start ? "it does not name a file" : NULL;
}

size_t stp_path_folder_length(const char* model)
{
    const char* slash = strrchr(model, '/');
    return slash != NULL ? (size_t)(slash + 1 - model) : 0;
}

bool stp_path_is_file(const char* path)
{
    struct stat status;
    return stat(path, &status) == 0 && S_ISREG(status.st_mode);
}

bool stp_path_is_below(const char* path, size_t folder_length)
{
    char folder[PATH_MAX];
    if (folder_length >= sizeof(folder)) {
        return false;
    }
    assert(folder_length == 0 || path[folder_length - 1] == '/');
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

const char* stp_path_resolve(const char* model, const char* reference, char* out)
{
    if (strlen(reference) > REFERENCE_LENGTH_LIMIT) {
        return "it is too long";
    }
    if (is_separator(reference[0])) {
        return "it is an absolute path";
    }
    if (has_scheme(reference)) {
        return "it has a drive letter or is a URL";
    }
    size_t folder_length = stp_path_folder_length(model);
    const char* reason = join(model, folder_length, reference, out);
    if (reason == NULL && !stp_path_is_below(out, folder_length)) {
        reason = "it is a link out of the folder of the file";
    }
    return reason;
}
