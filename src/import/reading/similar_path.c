// SPDX-License-Identifier: MIT
#include "import/reading/similar_path.h"

#include "import/reading/path_rules.h"

#include <assert.h>
#include <dirent.h>
#include <limits.h>
#include <string.h>
#include <sys/stat.h>

enum { NAMES_MAX = 1 << 20 }; // of a folder

static void lower_name(const char* name, size_t length, char* lower)
{
    for (size_t i = 0; i < length; ++i) {
        lower[i] = (char)(name[i] >= 'A' && name[i] <= 'Z' ? name[i] - 'A' + 'a' : name[i]);
    }
}

static void close_listing(stp_context* context, stp_folder_listing* listing)
{
    stp_free(context, listing->folder);
    stp_free(context, listing->starts);
    stp_free(context, listing->text);
    listing->names.context = context;
    stp_lookup_destroy(&listing->names);
    *listing = (stp_folder_listing){0};
}

void stp_folder_listings_close(stp_context* context, stp_folder_listings* listings)
{
    for (size_t i = 0; i < STP_FOLDER_LISTINGS; ++i) {
        close_listing(context, &listings->listings[i]);
    }
}

// Of names that differ in case only, the first by strcmp is kept.
static stp_result add_name(stp_context* context, stp_folder_listing* l, const char* name)
{
    char lower[NAME_MAX + 1];
    size_t length = strlen(name);
    uint32_t fresh = (uint32_t)l->count, found;
    if (length > NAME_MAX) {
        return STP_OK;
    }
    lower_name(name, length, lower);
    stp_result result = stp_lookup_add(&l->names, lower, length, fresh, &found);
    if (result != STP_OK) {
        return result;
    }
    if (found != fresh) {
        char* kept = l->text + l->starts[found];
        assert(strlen(kept) == length);
        memcpy(kept, strcmp(name, kept) < 0 ? name : kept, length);
        return STP_OK;
    }
    if (!STP_MAKE_ROOM(context, l->starts, l->capacity, l->count + 1) ||
        !STP_MAKE_ROOM(context, l->text, l->text_capacity, l->size + length + 1)) {
        return stp_fail_memory(context);
    }
    memcpy(l->text + l->size, name, length + 1);
    l->starts[l->count++] = l->size;
    l->size += length + 1;
    return STP_OK;
}

static stp_result read_listing(stp_context* context, const char* path, size_t length,
                               stp_folder_listing* l)
{
    *l = (stp_folder_listing){.names = {.context = context}};
    l->folder = stp_alloc(context, length + 1);
    if (l->folder == NULL) {
        return stp_fail_memory(context);
    }
    memcpy(l->folder, path, length);
    l->folder[length] = '\0';
    DIR* folder = opendir(length > 0 ? l->folder : ".");
    stp_result result = STP_OK;
    for (const struct dirent* entry; folder != NULL && result == STP_OK && l->count < NAMES_MAX &&
                                     (entry = readdir(folder)) != NULL;) {
        result = add_name(context, l, entry->d_name);
    }
    if (folder != NULL) {
        closedir(folder);
    }
    return result;
}

// The listing of the folder that is the first `length` bytes of a path.
static stp_result find_listing(stp_context* context, stp_folder_listings* listings,
                               const char* path, size_t length, const stp_folder_listing** found)
{
    for (size_t i = 0; i < STP_FOLDER_LISTINGS; ++i) {
        const stp_folder_listing* l = &listings->listings[i];
        if (l->folder != NULL && strncmp(l->folder, path, length) == 0 &&
            l->folder[length] == '\0') {
            *found = l;
            return STP_OK;
        }
    }
    stp_folder_listing* l = &listings->listings[listings->next];
    listings->next = (listings->next + 1) % STP_FOLDER_LISTINGS;
    close_listing(context, l);
    stp_result result = read_listing(context, path, length, l);
    if (result != STP_OK) {
        close_listing(context, l);
    }
    *found = l;
    return result;
}

static bool exists(char* path, size_t end)
{
    struct stat status;
    char after = path[end];
    path[end] = '\0';
    bool found = stat(path, &status) == 0;
    path[end] = after;
    return found;
}

// Replaces a name in a path, [begin, end), by one of its folder that differs in case at most: by the
// same one if it exists. *matched is false if there is none.
static stp_result match_name(stp_context* context, stp_folder_listings* listings, char* path,
                             size_t begin, size_t end, bool* matched)
{
    char lower[NAME_MAX + 1];
    size_t length = end - begin;
    assert(begin < end && end <= strlen(path));
    *matched = exists(path, end);
    if (*matched || length > NAME_MAX) {
        return STP_OK;
    }
    const stp_folder_listing* l;
    stp_result result = find_listing(context, listings, path, begin, &l);
    if (result != STP_OK) {
        return result;
    }
    lower_name(path + begin, length, lower);
    uint32_t index = stp_lookup_find(&l->names, lower, length, UINT32_MAX);
    *matched = index != UINT32_MAX;
    if (*matched) {
        memcpy(path + begin, l->text + l->starts[index], length);
    }
    return STP_OK;
}

static stp_result match_names(stp_context* context, stp_folder_listings* listings, char* path,
                              size_t folder_length, bool* matched)
{
    *matched = path[folder_length] != '\0';
    for (size_t begin = folder_length; path[begin] != '\0' && *matched;) {
        size_t end = begin + strcspn(path + begin, "/");
        *matched = end > begin;
        stp_result result =
            *matched ? match_name(context, listings, path, begin, end, matched) : STP_OK;
        if (result != STP_OK) {
            return result;
        }
        begin = end + (path[end] == '/');
    }
    *matched = *matched && stp_path_is_file(path) && stp_path_is_below(path, folder_length);
    return STP_OK;
}

stp_result stp_path_find_similar(stp_context* context, stp_folder_listings* listings, char* path,
                                 size_t folder_length)
{
    char other[PATH_MAX];
    size_t length = strlen(path);
    bool matched = false;
    stp_result result = STP_OK;
    if (length >= sizeof(other)) {
        return STP_OK;
    }
    assert(folder_length <= length);
    size_t query = folder_length + strcspn(path + folder_length, "?");
    for (int pass = 0; pass < (query < length ? 2 : 1) && !matched && result == STP_OK; ++pass) {
        memcpy(other, path, length + 1);
        other[pass == 0 ? length : query] = '\0';
        result = match_names(context, listings, other, folder_length, &matched);
    }
    if (result == STP_OK && matched) {
        memcpy(path, other, strlen(other) + 1);
    }
    return result;
}
