// SPDX-License-Identifier: MIT
#include "import/reading/similar_path.h"

#include "import/reading/path_rules.h"

#include <assert.h>
#include <dirent.h>
#include <limits.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>

static bool is_file(const char* path)
{
    struct stat status;
    return stat(path, &status) == 0 && S_ISREG(status.st_mode);
}

// Replaces a name in a path, [begin, end), by the first one of its folder that differs in case at
// most. @return false if there is none
static bool match_name(char* path, size_t begin, size_t end)
{
    char best[NAME_MAX + 1] = "", first = path[begin];
    size_t length = end - begin;
    assert(begin < end && end <= strlen(path));
    path[begin] = '\0';
    DIR* folder = opendir(begin > 0 ? path : ".");
    path[begin] = first;
    if (folder == NULL) {
        return false;
    }
    for (const struct dirent* entry; (entry = readdir(folder)) != NULL;) {
        const char* name = entry->d_name;
        if (strlen(name) == length && length <= NAME_MAX &&
            strncasecmp(name, path + begin, length) == 0 &&
            (best[0] == '\0' || strcmp(name, best) < 0)) {
            memcpy(best, name, length + 1);
        }
    }
    closedir(folder);
    if (best[0] != '\0') {
        memcpy(path + begin, best, length);
    }
    return best[0] != '\0';
}

static bool match_names(char* path, size_t folder_length)
{
    for (size_t begin = folder_length; path[begin] != '\0';) {
        size_t end = begin + strcspn(path + begin, "/");
        if (end == begin || !match_name(path, begin, end)) {
            return false;
        }
        begin = end + (path[end] == '/');
    }
    return is_file(path) && stp_path_is_below(path, folder_length);
}

bool stp_path_find_similar(char* path, size_t folder_length)
{
    char other[PATH_MAX];
    size_t length = strlen(path);
    if (length >= sizeof(other)) {
        return false;
    }
    assert(folder_length <= length);
    for (int query = 0; query < 2; ++query) {
        memcpy(other, path, length + 1);
        if (query != 0) {
            other[folder_length + strcspn(other + folder_length, "?")] = '\0';
        }
        if (other[folder_length] != '\0' && match_names(other, folder_length)) {
            memcpy(path, other, strlen(other) + 1);
            return true;
        }
    }
    return false;
}
