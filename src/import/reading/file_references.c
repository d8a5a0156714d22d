// SPDX-License-Identifier: MIT
// Resolves file references of the imported model.
#include "import/reading/import.h"
#include "import/reading/path_rules.h"

#include <assert.h>
#include <string.h>

// On STP_OK either *path or *reason is set.
static stp_result resolve(stp_import* import, const char* reference, const char** path,
                          const char** reason)
{
    *path = NULL;
    *reason = NULL;
    if (import->alone) {
        *reason = "the model was read from memory";
        return STP_OK;
    }
    char* joined =
        stp_arena_alloc(&import->scene->text, strlen(import->path) + strlen(reference) + 2);
    if (joined == NULL) {
        return stp_fail_memory(import->context);
    }
    *reason = stp_path_resolve(import->path, reference, joined);
    stp_result result = STP_OK;
    if (*reason == NULL && !stp_path_is_file(joined)) {
        result = stp_path_find_similar(import->context, &import->folders, joined,
                                       stp_path_folder_length(import->path));
    }
    *path = *reason == NULL ? joined : NULL;
    return result;
}

stp_result stp_import_resolve(stp_import* import, const char* reference, const char** path)
{
    const char* reason;
    stp_result result = resolve(import, reference, path, &reason);
    assert(result != STP_OK || (*path == NULL) == (reason != NULL));
    if (result == STP_OK && *path == NULL) {
        return stp_fail(import->context, STP_ERROR_FORMAT,
                        "%s: the reference \"%.200s\" is rejected: %s", import->path, reference,
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
    if (*path != NULL && !stp_path_is_file(*path)) {
        reason = "the file does not exist";
        *path = NULL;
    }
    assert(*path != NULL || reason != NULL);
    if (*path == NULL) {
        stp_warn(import->context, "%s: %s: \"%.200s\" is left out: %s", import->path, place,
                 reference, reason);
    }
    return STP_OK;
}
