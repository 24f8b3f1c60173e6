/* SPDX-License-Identifier: Apache-2.0 */
/* Running the program beside a test, which sends signals to it or limits it. */
#ifndef MCVISI_TESTS_CHILD_H
#define MCVISI_TESTS_CHILD_H

#include "program.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdbool.h>
#include <sys/resource.h>
#include <time.h>

enum { CHILD_WORDS = 64 };

/* The program with a line of words, split at spaces, in a process group of its own; its output goes
 * to the file child.log. file_bytes: the largest file that it may write, 0: any. */
static inline pid_t child_start(const char *line, rlim_t file_bytes) {
    char words[4096], *argv[CHILD_WORDS] = {(char *)"mcvisi"}, *rest = NULL;
    int argc = 1;
    assert_true(strlen(line) < sizeof words);
    strcpy(words, line);
    for (char *word = strtok_r(words, " ", &rest); word && argc < CHILD_WORDS - 1;
         word = strtok_r(NULL, " ", &rest))
        argv[argc++] = word;
    const pid_t child = fork();
    assert_true(child >= 0);
    if (child > 0) return child;
    const struct rlimit limit = {file_bytes, file_bytes};
    const int log = open("child.log", O_WRONLY | O_CREAT | O_TRUNC, 0666);
    setpgid(0, 0);
    signal(SIGHUP, SIG_DFL); /* It is ignored where the tests run under nohup. */
    dup2(log, STDOUT_FILENO);
    dup2(log, STDERR_FILENO);
    if (file_bytes) setrlimit(RLIMIT_FSIZE, &limit);
    execv(MCV_BINARY_DIR "/mcvisi", argv);
    _exit(127);
}

/* Its exit code; minus the signal that ended it. `said` is its output then. */
static inline int child_end(pid_t child) {
    int status = 0;
    while (waitpid(child, &status, 0) < 0) assert_int_equal(errno, EINTR);
    FILE *log = fopen("child.log", "r");
    said[log ? fread(said, 1, sizeof said - 1, log) : 0] = '\0';
    if (log) fclose(log);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
}

/* Whether it has ended; it is still to be waited for. */
static inline bool child_ended(pid_t child) {
    siginfo_t info = {.si_pid = 0};
    return waitid(P_PID, (id_t)child, &info, WEXITED | WNOHANG | WNOWAIT) == 0 && info.si_pid != 0;
}

static inline void sleep_for(double seconds) {
    const struct timespec time = {(time_t)seconds,
                                  (long)(1e9 * (seconds - (double)(time_t)seconds))};
    nanosleep(&time, NULL);
}

static inline double now(void) {
    struct timespec time;
    clock_gettime(CLOCK_MONOTONIC, &time);
    return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

/* Waits until it has a handler of this signal, or has ended: half a minute at most. */
static inline void child_wait_for_handler(pid_t child, int signal) {
    char path[64], line[256];
    snprintf(path, sizeof path, "/proc/%d/status", (int)child);
    for (int i = 0; i < 3000 && !child_ended(child); ++i, sleep_for(0.01)) {
        unsigned long long caught = 0;
        FILE *status = fopen(path, "r");
        while (status && fgets(line, sizeof line, status))
            if (strncmp(line, "SigCgt:", 7) == 0) caught = strtoull(line + 7, NULL, 16);
        if (status) fclose(status);
        if (caught >> (signal - 1) & 1) return;
    }
}

/* The number of files in a folder whose names hold the word. */
static inline int files_named(const char *folder, const char *word) {
    DIR *directory = opendir(folder);
    int count = 0;
    for (struct dirent *entry; directory && (entry = readdir(directory));)
        count += entry->d_name[0] != '.' && strstr(entry->d_name, word) != NULL;
    if (directory) closedir(directory);
    return count;
}

#endif
