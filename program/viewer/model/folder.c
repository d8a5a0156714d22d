// SPDX-License-Identifier: MIT
#define _XOPEN_SOURCE 700 // realpath
#include "program/viewer/model/folder.h"

#include "import/reading/import.h"

#include <assert.h>
#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>

const char* folder_formats(char* text, size_t size)
{
    size_t used = (size_t)snprintf(text, size, "Stipple (.stip)");
    const stp_importer* importer;
    for (size_t i = 0; used < size && (importer = stp_import_listed(i)) != NULL; ++i) {
        used += (size_t)snprintf(text + used, size - used, ", %s (", importer->title);
        const char* at = stp_importer_listed(importer);
        for (const char* separator = ""; *at != 0 && used < size; separator = " ") {
            int length = (int)strcspn(at, " ");
            used += (size_t)snprintf(text + used, size - used, "%s.%.*s", separator, length, at);
            at += length + (at[length] == ' ');
        }
        used += used < size ? (size_t)snprintf(text + used, size - used, ")") : 0;
    }
    return text;
}

static bool is_model(const char* name)
{
    size_t length = strlen(name);
    bool built = length > 5 && strcasecmp(name + length - 5, ".stip") == 0;
    return built || stp_import_lists(name);
}

bool folder_filter(const folder_entry* entry, const char* typed)
{
    size_t length = strlen(typed);
    for (const char* at = entry->name; strlen(at) >= length; ++at) {
        if (strncasecmp(at, typed, length) == 0) {
            return true;
        }
    }
    return false;
}

bool folder_complete(const folder_list* f, const char* start, char* name, size_t size)
{
    size_t length = strlen(start), matches = 0;
    bool is_folder = false;
    name[0] = 0;
    for (size_t i = 0; i < f->count; ++i) {
        const folder_entry* e = &f->entries[i];
        if (strncasecmp(e->name, start, length) != 0) {
            continue;
        }
        if (matches == 0) {
            snprintf(name, size, "%s", e->name);
            is_folder = e->is_folder;
        }
        size_t same = 0;
        while (name[same] != 0 && strncasecmp(name, e->name, same + 1) == 0) {
            same += 1;
        }
        while (same > 0 && (name[same] & 0xC0) == 0x80) { // not within a character
            same -= 1;
        }
        name[same] = 0;
        matches += 1;
    }
    length = strlen(name);
    if (matches == 1 && is_folder && length + 1 < size) {
        memcpy(name + length, "/", 2);
    }
    return matches > 0;
}

bool folder_join(const folder_list* f, const char* name, char path[PATH_MAX])
{
    int length;
    if (strcmp(name, "..") == 0) {
        const char* slash = strrchr(f->path, '/');
        size_t kept = slash != NULL && slash != f->path ? (size_t)(slash - f->path) : 1;
        length = snprintf(path, PATH_MAX, "%.*s", (int)kept, f->path[0] != 0 ? f->path : "/");
    } else {
        const char* slash = strcmp(f->path, "/") == 0 ? "" : "/";
        length = snprintf(path, PATH_MAX, "%s%s%s", f->path, slash, name);
    }
    return length > 0 && length < PATH_MAX;
}

static int compare_entries(const void* a, const void* b)
{
    const folder_entry *x = a, *y = b;
    if (x->is_folder != y->is_folder) {
        return x->is_folder ? -1 : 1;
    }
    int order = strcasecmp(x->name, y->name);
    return order != 0 ? order : strcmp(x->name, y->name);
}

/// @return false if memory runs out
static bool add(folder_list* f, const char* name, bool is_folder, uint64_t bytes)
{
    if (f->count == f->capacity) {
        size_t wanted = 2 * f->capacity + 64;
        folder_entry* larger = realloc(f->entries, wanted * sizeof(*larger));
        if (larger == NULL) {
            return false;
        }
        f->entries = larger;
        f->capacity = wanted;
    }
    char* copy = strdup(name);
    if (copy == NULL) {
        return false;
    }
    f->entries[f->count++] = (folder_entry){.name = copy, .is_folder = is_folder, .bytes = bytes};
    return true;
}

bool folder_read(folder_list* f, const char* path, bool all)
{
    folder_list read = {0};
    DIR* dir = realpath(path, read.path) != NULL ? opendir(read.path) : NULL;
    if (dir == NULL) {
        return false;
    }
    assert(read.path[0] == '/' && "paths of entries are absolute");
    for (struct dirent* entry; (entry = readdir(dir)) != NULL;) {
        char whole[PATH_MAX];
        struct stat status;
        if (entry->d_name[0] == '.' || !folder_join(&read, entry->d_name, whole) ||
            stat(whole, &status) != 0) {
            continue;
        }
        bool is_folder = S_ISDIR(status.st_mode);
        if (!is_folder && (!S_ISREG(status.st_mode) || !(all || is_model(entry->d_name)))) {
            continue;
        }
        if (read.count == FOLDER_ENTRIES_MAX ||
            !add(&read, entry->d_name, is_folder, (uint64_t)status.st_size)) {
            read.is_truncated = true;
            break;
        }
    }
    closedir(dir);
    if (read.count > 0) {
        qsort(read.entries, read.count, sizeof(read.entries[0]), compare_entries);
    }
    folder_destroy(f);
    *f = read;
    return true;
}

void folder_destroy(folder_list* f)
{
    for (size_t i = 0; i < f->count; ++i) {
        free(f->entries[i].name);
    }
    free(f->entries);
    *f = (folder_list){0};
}
