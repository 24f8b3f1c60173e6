/* SPDX-License-Identifier: Apache-2.0 */
/* Ctrl-C while a page's pictures are rendered, after the last row: exit code 130, whole rows and
 * files, and the same command ends the work. */
#include "test.h"

#include "child.h"
#include "experiment_files.h"

/* A ball with a dent, of which a study shows pictures. */
static const char scene[] =
    "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0,1,2]}],"
    "\"extensionsUsed\":[\"MCVISI_defects\",\"MCVISI_emitters\",\"MCVISI_materials\","
    "\"MCVISI_sensors\",\"MCVISI_surfaces\"],\"materials\":[{\"extensions\":{"
    "\"MCVISI_materials\":{\"type\":\"diffuse\",\"reflectance\":0.5}}}],"
    "\"extensions\":{\"MCVISI_sensors\":{\"sensors\":[{\"name\":\"cam\",\"type\":"
    "\"telecentric\",\"magnification\":1,\"workingDistance\":0.1,\"fNumber\":8,"
    "\"resolution\":[16,12],\"pixelSize\":2e-4}]},\"MCVISI_emitters\":{\"emitters\":[{"
    "\"name\":\"sky\",\"type\":\"environment\",\"radiance\":1}]},"
    "\"MCVISI_surfaces\":{\"surfaces\":[{\"type\":\"sphere\",\"radius\":\"3mm\","
    "\"material\":0}]},\"MCVISI_defects\":{\"defects\":[{\"name\":\"nick\",\"type\":"
    "\"dent\",\"node\":\"ball\",\"at\":[0,0,\"3mm\"],\"size\":1e-3}]}},"
    "\"nodes\":[{\"name\":\"ball\",\"extensions\":{\"MCVISI_surfaces\":{\"surface\":0}}}"
    ",{\"name\":\"cam\",\"translation\":[0,0,0.1],\"extensions\":{\"MCVISI_sensors\":{"
    "\"sensor\":0}}},{\"name\":\"sky\",\"extensions\":{\"MCVISI_emitters\":{\"emitter\":"
    "0}}}]}";

static size_t lines_of(const char *path) {
    char text[65536];
    FILE *file = fopen(path, "r");
    text[file ? fread(text, 1, sizeof text - 1, file) : 0] = '\0';
    if (file) fclose(file);
    return count_lines(text);
}

/* Sends SIGINT once the table has its last row; the exit code. */
static int interrupt_after(const char *line, const char *table, size_t rows) {
    const pid_t child = child_start(line, 0);
    while (lines_of(table) < rows + 1 && !child_ended(child)) sleep_for(0.005);
    sleep_for(0.02); /* into a picture */
    kill(child, SIGINT);
    return child_end(child);
}

/* What is interrupted. Of twice the effort each picture takes twice as long. */
typedef struct work {
    size_t (*begin)(int effort, char line[1024]); /* the line, and the rows that it ends with */
    const char *table;
    int code; /* of the whole work */
} work;

/* On a busy machine the signal may come after the end: then each picture must take longer. */
static void expect_130(const work *w) {
    int code = w->code;
    size_t rows = 0;
    for (int effort = 1; code == w->code && effort <= 16; effort *= 2) {
        char line[1024];
        rows = w->begin(effort, line);
        remove(w->table);
        code = interrupt_after(line, w->table, rows);
    }
    if (code != 130) fail_msg("exit code %d: must be 130: %s", code, said);
    if (lines_of(w->table) != rows + 1) fail_msg("%s: must have %zu whole rows", w->table, rows);
    assert_int_equal(files_named(".", ".part"), 0);
}

static size_t begin_study(int effort, char line[1024]) {
    char study[1024];
    snprintf(study, sizeof study,
             "{\"rig\": \"dented.gltf\", \"vary\": \"defects/nick/size=1mm\", \"metric\": "
             "\"grey:=mean\", \"device\": \"reference\", \"threads\": 1, \"spp\": %d, "
             "\"pod\": {\"size\": \"size\", \"signal\": \"grey\", \"threshold\": \"1\"}}",
             1024 * effort);
    write_file("study.json", study);
    strcpy(line, "pod study.json");
    return 1;
}

/* One set is too few for a study, which says so after the pictures: exit code 3. */
static void test_a_study_stops(void **state) {
    (void)state;
    expect_130(&(work){begin_study, "study-sweep.csv", 3});
    if (!strstr(said, "continue by the same command; 1 row is in study-sweep.csv"))
        fail_msg("no sentence says how it continues: %s", said);
    assert_int_equal(access("study-pod.html", F_OK), -1); /* it has pictures */
}

static size_t begin_search(int effort, char line[1024]) {
    snprintf(line, 1024,
             "optimize " MCV_SOURCE_DIR "/scenes/beam.gltf --vary emitters/beam/power=1..12 "
             "--metric mean --objective mean=largest --evaluations 20 --device reference "
             "--threads 1 --resolution 16x16 --spp %d --force --json -o s.csv",
             512 * effort);
    json_t *report = program_json(line);
    const size_t rows = (size_t)number_at(report, "rows");
    json_decref(report);
    return rows;
}

static void test_a_search_stops(void **state) {
    (void)state;
    expect_130(&(work){begin_search, "s.csv", 0});
    if (!strstr(said, "continue by --resume; ") || !strstr(said, " in s.csv"))
        fail_msg("no sentence says how it continues: %s", said);
    /* The page is whole, but for the pictures. */
    const char *page = read_whole("s.html");
    assert_non_null(strstr(page, "The best set-up is power "));
    assert_non_null(strstr(page, "</html>"));
    assert_null(strstr(page, "What the camera sees"));
    program_well("optimize s.json --resume -o s.csv");
    assert_non_null(strstr(read_whole("s.html"), "What the camera sees"));
}

static int enter(void **state) {
    const int result = enter_folder(state);
    if (result == 0) write_file("dented.gltf", scene);
    return result;
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_a_study_stops),
        cmocka_unit_test(test_a_search_stops),
    };
    return cmocka_run_group_tests(tests, enter, leave_folder);
}
