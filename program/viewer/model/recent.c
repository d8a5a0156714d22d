// SPDX-License-Identifier: MIT
#include "base/io/file.h"
#include "program/viewer/model/folder.h"

#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

enum { TEXT_MAX = RECENT_MAX * PATH_MAX };

void recent_remove(recent_files* recent, const char* path)
{
    size_t kept = 0;
    for (size_t i = 0; i < recent->count; ++i) {
        if (strcmp(recent->paths[i], path) != 0) {
            if (kept != i) {
                memcpy(recent->paths[kept], recent->paths[i], PATH_MAX);
            }
            kept += 1;
        }
    }
    recent->count = kept;
}

void recent_add(recent_files* recent, const char* path)
{
    if (path[0] != '/' || strchr(path, '\n') != NULL || strlen(path) >= PATH_MAX) {
        return;
    }
    recent_remove(recent, path);
    size_t kept = recent->count < RECENT_MAX ? recent->count : RECENT_MAX - 1;
    memmove(recent->paths[1], recent->paths[0], kept * sizeof(recent->paths[0]));
    snprintf(recent->paths[0], PATH_MAX, "%s", path);
    recent->count = kept + 1;
    assert(recent->count <= RECENT_MAX);
}

void recent_parse(recent_files* recent, const char* text)
{
    while (*text != 0 && recent->count < RECENT_MAX) {
        size_t length = strcspn(text, "\n");
        if (text[0] == '/' && length < PATH_MAX) {
            char* place = recent->paths[recent->count];
            memcpy(place, text, length);
            place[length] = 0;
            bool known = false;
            for (size_t i = 0; i < recent->count; ++i) {
                known = known || strcmp(recent->paths[i], place) == 0;
            }
            recent->count += known ? 0 : 1;
        }
        text += length + (text[length] == '\n');
    }
}

/// Creates the parent folders of a path.
static void make_folders(char* path)
{
    for (char* slash = strchr(path + 1, '/'); slash != NULL; slash = strchr(slash + 1, '/')) {
        *slash = 0;
        (void)mkdir(path, 0700);
        *slash = '/';
    }
}

/// @return false if there is no folder for the list
static bool find_file(char path[PATH_MAX])
{
    const char *state = getenv("XDG_STATE_HOME"), *home = getenv("HOME");
    int length = 0;
    if (state != NULL && state[0] == '/') {
        length = snprintf(path, PATH_MAX, "%s/stipple/recent", state);
    } else if (home != NULL && home[0] == '/') {
        length = snprintf(path, PATH_MAX, "%s/.local/state/stipple/recent", home);
    }
    return length > 0 && length < PATH_MAX - 8;
}

void recent_load(recent_files* recent)
{
    char path[PATH_MAX];
    *recent = (recent_files){0};
    char* text = find_file(path) ? malloc(TEXT_MAX + 1) : NULL;
    if (text != NULL) {
        text[stp_file_peek(path, text, TEXT_MAX)] = 0;
        recent_parse(recent, text);
    }
    free(text);
}

void recent_save(const recent_files* recent)
{
    char path[PATH_MAX], aside[PATH_MAX + 8];
    if (!find_file(path)) {
        return;
    }
    make_folders(path);
    snprintf(aside, sizeof(aside), "%s.new", path);
    FILE* file = fopen(aside, "wb");
    bool written = file != NULL;
    for (size_t i = 0; written && i < recent->count; ++i) {
        written = fprintf(file, "%s\n", recent->paths[i]) > 0;
    }
    written = file != NULL && fclose(file) == 0 && written;
    if (file != NULL && (!written || rename(aside, path) != 0)) {
        (void)remove(aside);
    }
}
