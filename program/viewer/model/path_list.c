// SPDX-License-Identifier: MIT
#include "program/viewer/model/path_list.h"

#include "import/reading/import.h"
#include "program/viewer/model/folder.h"

#include <stdlib.h>
#include <string.h>

bool path_list_add(path_list* list, const char* path)
{
    char** larger = list->count < PATH_LIST_MAX
                        ? realloc(list->paths, (list->count + 1) * sizeof(*larger))
                        : NULL;
    if (larger == NULL) {
        return false;
    }
    list->paths = larger;
    list->paths[list->count] = strdup(path);
    bool added = list->paths[list->count] != NULL;
    list->count += added ? 1 : 0;
    return added;
}

bool path_list_expand(path_list* list, const char* path)
{
    folder_list f = {0};
    if (!folder_read(&f, path, false)) {
        return path_list_add(list, path);
    }
    bool good = !f.is_truncated;
    for (size_t i = 0; i < f.count && good; ++i) {
        char whole[PATH_MAX];
        const folder_entry* e = &f.entries[i];
        if (!e->is_folder && stp_import_lists(e->name) && folder_join(&f, e->name, whole)) {
            good = path_list_add(list, whole);
        }
    }
    folder_destroy(&f);
    return good;
}

void path_list_destroy(path_list* list)
{
    for (size_t i = 0; i < list->count; ++i) {
        free(list->paths[i]);
    }
    free(list->paths);
    *list = (path_list){0};
}
