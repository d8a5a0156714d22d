// SPDX-License-Identifier: MIT
//
// All other formats that assimp reads (FBX, DAE, 3DS, IFC, X3D, BLEND, ...), in a child process
// with memory and time limits: a crash, a hang or excessive memory use becomes a one-sentence
// error. The scene is returned through a pipe (assimp_stream.h).
#include "import/assimp/assimp_files.h"
#include "import/assimp/assimp_stream.h"
#include "import/assimp/sandbox.h"
#include "import/reading/advice.h"

#include <assert.h>
#include <assimp/cimport.h>
#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>
#ifdef __linux__
#include <sys/prctl.h>
#endif

#define DEFAULT_SECONDS 600
#define READ_SIZE ((size_t)1 << 20)
#define POLL_MS 100

// The parent's state of the child.
typedef struct helper {
    stp_import* import;
    stp_context* context;
    pid_t process;
    int descriptor; ///< read end of the stream's pipe
    uint64_t memory_limit;
    uint32_t seconds;       ///< wall-clock time, and the maximum CPU time
    uint64_t first_seconds; ///< CPU time for the model's own bytes; referenced files add to it
    double deadline;
    unsigned char* bytes;
    size_t size, capacity;
} helper;

static double now(void)
{
    struct timespec time;
    clock_gettime(CLOCK_MONOTONIC, &time);
    return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

// Address space in use, which the child inherits and which does not count against its limit.
static uint64_t used_address_space(void)
{
    char text[64] = {0};
    int file = open("/proc/self/statm", O_RDONLY | O_CLOEXEC);
    uint64_t pages = 0;
    if (file >= 0 && read(file, text, sizeof(text) - 1) > 0) {
        for (const char* at = text; *at >= '0' && *at <= '9'; ++at) {
            pages = pages * 10 + (uint64_t)(*at - '0');
        }
    }
    if (file >= 0) {
        close(file);
    }
    return pages * (uint64_t)sysconf(_SC_PAGESIZE);
}

// The process may raise `max_now` up to `maximum` later.
static void limit_softly(int resource, uint64_t max_now, uint64_t maximum)
{
    struct rlimit old, limits = {.rlim_cur = (rlim_t)max_now, .rlim_max = (rlim_t)maximum};
    if (getrlimit(resource, &old) == 0 && old.rlim_max < limits.rlim_max) {
        limits.rlim_max = old.rlim_max;
    }
    limits.rlim_cur = limits.rlim_cur < limits.rlim_max ? limits.rlim_cur : limits.rlim_max;
    (void)setrlimit(resource, &limits);
}

static void limit(int resource, uint64_t maximum)
{
    limit_softly(resource, maximum, maximum);
}

// Never returns.
static void run_child(const helper* h, int descriptor)
{
    assert(descriptor > 2 && "the standard streams are replaced");
    static const int signals[] = {SIGSEGV, SIGBUS,  SIGABRT, SIGFPE,
                                  SIGILL,  SIGTERM, SIGXCPU, SIGPIPE};
    for (size_t i = 0; i < sizeof(signals) / sizeof(signals[0]); ++i) {
        (void)signal(signals[i], SIG_DFL); // the host's signal handlers must not run here
    }
#ifdef __linux__
    (void)prctl(PR_SET_PDEATHSIG, SIGKILL);
#endif
    limit(RLIMIT_CORE, 0);
    limit_softly(RLIMIT_CPU, h->first_seconds, h->seconds);
    limit(RLIMIT_FSIZE, 0);
    limit(RLIMIT_AS, used_address_space() + h->memory_limit);
    int null = open("/dev/null", O_RDWR);
    for (int i = 0; null >= 0 && i < 3; ++i) {
        (void)dup2(null, i); // assimp's readers print messages
    }
    const stp_import* import = h->import;
    const char* slash = strrchr(import->path, '/');
    size_t length = slash != NULL ? (size_t)(slash + 1 - import->path) : 0;
    char* folder = malloc(length + 1);
    if (folder == NULL) {
        _exit(1);
    }
    memcpy(folder, import->path, length);
    folder[length] = '\0';
    stp_sandbox_enter(import->alone ? NULL : length > 0 ? folder : ".", descriptor);
    int code = stp_assimp_run_child(import->path, import->file.bytes, import->file.size,
                                    import->alone, descriptor);
    _exit(code);
}

static stp_result start(helper* h)
{
    int ends[2];
    if (pipe(ends) != 0) {
        return stp_fail(h->context, STP_ERROR_IO, "%s: cannot create a pipe to a child process: %s",
                        h->import->path, strerror(errno));
    }
    (void)fcntl(ends[0], F_SETFD, FD_CLOEXEC);
    (void)fcntl(ends[1], F_SETFD, FD_CLOEXEC);
    // the write end must not be one of the standard streams, which the child replaces
    int writing = ends[1] > 2 ? ends[1] : fcntl(ends[1], F_DUPFD_CLOEXEC, 3);
    h->process = writing >= 0 ? fork() : -1;
    if (h->process == 0) {
        run_child(h, writing);
    }
    int reason = errno;
    if (writing != ends[1] && writing >= 0) {
        close(writing);
    }
    close(ends[1]);
    h->descriptor = ends[0];
    if (h->process < 0) {
        close(ends[0]);
        return stp_fail(h->context, STP_ERROR_IO, "%s: cannot start a child process to read it: %s",
                        h->import->path, strerror(reason));
    }
    h->deadline = now() + (double)h->seconds;
    return STP_OK;
}

// Reads the available data. *ended is set at the end of the stream.
static stp_result receive(helper* h, bool* ended)
{
    if (!STP_MAKE_ROOM(h->context, h->bytes, h->capacity, h->size + READ_SIZE)) {
        return stp_fail_memory(h->context);
    }
    assert(h->size < h->capacity);
    ssize_t count = read(h->descriptor, h->bytes + h->size, h->capacity - h->size);
    if (count < 0 && errno != EINTR && errno != EAGAIN) {
        return stp_fail(h->context, STP_ERROR_IO, "%s: the pipe to assimp broke: %s",
                        h->import->path, strerror(errno));
    }
    *ended = count == 0;
    h->size += count > 0 ? (size_t)count : 0;
    if (h->size > h->memory_limit) {
        return stp_assimp_fail_memory(h->import);
    }
    return STP_OK;
}

// Reads until the end of the stream. *status and *reaped are set if the child has already ended.
static stp_result receive_all(helper* h, int* status, bool* reaped)
{
    bool ended = false;
    while (!ended) {
        struct pollfd poller = {.fd = h->descriptor, .events = POLLIN};
        int ready = poll(&poller, 1, POLL_MS);
        stp_result result = STP_OK;
        if (ready > 0) {
            result = receive(h, &ended);
        } else if (*reaped) {
            return STP_OK; // it has ended and nothing is left, but another process has the pipe
        } else {
            result = stp_progress(h->context, "import", 0.2);
            *reaped = waitpid(h->process, status, WNOHANG) == h->process;
        }
        if (result != STP_OK) {
            return result;
        }
        if (!*reaped && now() > h->deadline) {
            return stp_fail(h->context, STP_ERROR_LIMIT,
                            "%s: assimp takes longer than %u seconds to read it", h->import->path,
                            (unsigned)h->seconds);
        }
    }
    return STP_OK;
}

static stp_result check_exit(const helper* h, int status)
{
    if (WIFSIGNALED(status) && (WTERMSIG(status) == SIGXCPU || WTERMSIG(status) == SIGKILL)) {
        return stp_fail(h->context, STP_ERROR_LIMIT,
                        "%s: assimp was stopped while reading it: out of time or memory",
                        h->import->path);
    }
    if (WIFSIGNALED(status)) {
        return stp_fail(h->context, STP_ERROR_FORMAT,
                        "%s: assimp crashed while reading it (signal %d)", h->import->path,
                        WTERMSIG(status));
    }
    if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) {
        return stp_fail(h->context, STP_ERROR_FORMAT, "%s: assimp gave up while reading it",
                        h->import->path);
    }
    return STP_OK;
}

static stp_result run_helper(helper* h)
{
    stp_result result = start(h);
    if (result != STP_OK) {
        return result;
    }
    int status = 0;
    bool reaped = false;
    assert(h->process > 0 && "kill and waitpid take other numbers for groups");
    result = receive_all(h, &status, &reaped);
    close(h->descriptor);
    if (result != STP_OK && !reaped) {
        (void)kill(h->process, SIGKILL);
    }
    pid_t found = reaped ? h->process : -1;
    while (!reaped && (found = waitpid(h->process, &status, 0)) < 0 && errno == EINTR) {
    }
    // if the host reaps all children itself, there is no status: only the stream shows success
    return result == STP_OK && found == h->process ? check_exit(h, status) : result;
}

static bool assimp_knows(const char* path)
{
    const char* slash = strrchr(path, '/');
    const char* dot = strrchr(slash != NULL ? slash : path, '.');
    return dot != NULL && aiIsExtensionSupported(dot) == AI_TRUE;
}

static stp_result read_foreign(stp_import* import)
{
    if (!assimp_knows(import->path)) {
        return stp_import_refuse_unknown(import);
    }
    if (import->file.size == 0) {
        return stp_fail(import->context, STP_ERROR_TRUNCATED, "%s: is empty", import->path);
    }
    const stp_import_desc* desc = &import->desc;
    helper h = {.import = import,
                .context = import->context,
                .memory_limit = stp_assimp_memory_limit(import),
                .seconds = DEFAULT_SECONDS,
                .first_seconds = STP_ASSIMP_SECONDS + stp_assimp_seconds_for(import->file.size)};
    if (desc->helper_seconds != 0) {
        h.seconds = desc->helper_seconds;
        h.first_seconds = desc->helper_seconds;
    }
    stp_result result = run_helper(&h);
    if (result == STP_OK) {
        result = stp_assimp_read_stream(import, h.bytes, h.size);
    }
    stp_free(h.context, h.bytes);
    return result;
}

const stp_importer stp_importer_assimp = {
    .name = "assimp",
    .title = "through assimp",
    .listed = "fbx dae 3ds 3mf ifc x3d blend dxf x off lwo lws ac amf ase b3d bvh cob csm hmp iqm "
              "irr irrmesh lxo md2 md3 md5mesh mdl ms3d nff ogex q3o q3s smd xgl zgl",
    .read = read_foreign,
    .fallback = true};
