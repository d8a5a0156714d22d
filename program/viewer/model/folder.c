// SPDX-License-Identifier: MIT
#define _XOPEN_SOURCE 700 // realpath
#include "program/viewer/model/folder.h"

#include <assert.h>
#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>

const char folder_formats[] =
    "Stipple (.stip), glTF 2.0 (.gltf, .glb), OBJ, PLY (meshes and point clouds), STL, E57, PTX, "
    "PTS, PCD, XYZ, CSV, ASC, SRTM heights (.hgt); through assimp "
    "also FBX, COLLADA (.dae), 3DS, 3MF, IFC, X3D, Blender, DXF and others";

static const char* const suffixes[] = {
    "stip", "gltf", "glb", "obj", "ply", "stl",  "fbx", "dae",  "3ds", "blend", "ifc", "dxf",
    "x3d",  "x",    "off", "lwo", "lws", "ac",   "3mf", "ase",  "b3d", "bvh",   "cob", "csm",
    "hmp",  "irr",  "md2", "md3", "mdl", "ms3d", "nff", "ogex", "q3o", "raw",   "smd", "ter",
    "amf",  "wrl",  "e57", "ptx", "pts", "pcd",  "xyz", "csv",  "asc", "hgt",
};

/// Whether a file's name has the extension of a supported format, ignoring case.
static bool is_model(const char* name)
{
    const char* dot = strrchr(name, '.');
    for (size_t i = 0; dot != NULL && i < sizeof(suffixes) / sizeof(suffixes[0]); ++i) {
        if (strcasecmp(dot + 1, suffixes[i]) == 0) {
            return true;
        }
    }
    return false;
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
