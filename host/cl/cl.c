/* SPDX-License-Identifier: Apache-2.0 */
#include "cl/cl.h"

#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>

#include "cl/cache.h"
#include "cl/flatten.h"
#include "cl/pocl_cache.h"
#include "cl/program_cache.h"
#include "cl/programs.h"

enum { MAX_PLATFORMS = 16, MAX_DEVICES = 64, BUILD_LOG_SHOWN = 1200 };
enum { NO_PLATFORM = -1001 }; /* CL_PLATFORM_NOT_FOUND_KHR: the loader knows no driver */

#define MCV_CL_ERRORS(X) \
    X(CL_DEVICE_NOT_FOUND) \
    X(CL_DEVICE_NOT_AVAILABLE) \
    X(CL_COMPILER_NOT_AVAILABLE) \
    X(CL_MEM_OBJECT_ALLOCATION_FAILURE) \
    X(CL_OUT_OF_RESOURCES) \
    X(CL_OUT_OF_HOST_MEMORY) \
    X(CL_PROFILING_INFO_NOT_AVAILABLE) \
    X(CL_MEM_COPY_OVERLAP) \
    X(CL_BUILD_PROGRAM_FAILURE) \
    X(CL_MAP_FAILURE) \
    X(CL_MISALIGNED_SUB_BUFFER_OFFSET) \
    X(CL_EXEC_STATUS_ERROR_FOR_EVENTS_IN_WAIT_LIST) \
    X(CL_INVALID_VALUE) \
    X(CL_INVALID_DEVICE_TYPE) \
    X(CL_INVALID_PLATFORM) \
    X(CL_INVALID_DEVICE) \
    X(CL_INVALID_CONTEXT) \
    X(CL_INVALID_QUEUE_PROPERTIES) \
    X(CL_INVALID_COMMAND_QUEUE) \
    X(CL_INVALID_HOST_PTR) \
    X(CL_INVALID_MEM_OBJECT) \
    X(CL_INVALID_BINARY) \
    X(CL_INVALID_BUILD_OPTIONS) \
    X(CL_INVALID_PROGRAM) \
    X(CL_INVALID_PROGRAM_EXECUTABLE) \
    X(CL_INVALID_KERNEL_NAME) \
    X(CL_INVALID_KERNEL_DEFINITION) \
    X(CL_INVALID_KERNEL) \
    X(CL_INVALID_ARG_INDEX) \
    X(CL_INVALID_ARG_VALUE) \
    X(CL_INVALID_ARG_SIZE) \
    X(CL_INVALID_KERNEL_ARGS) \
    X(CL_INVALID_WORK_DIMENSION) \
    X(CL_INVALID_WORK_GROUP_SIZE) \
    X(CL_INVALID_WORK_ITEM_SIZE) \
    X(CL_INVALID_GLOBAL_OFFSET) \
    X(CL_INVALID_EVENT_WAIT_LIST) \
    X(CL_INVALID_EVENT) \
    X(CL_INVALID_OPERATION) \
    X(CL_INVALID_BUFFER_SIZE) \
    X(CL_INVALID_GLOBAL_WORK_SIZE)

const char *mcv_cl_error_name(cl_int code) {
    switch (code) {
#define MCV_X(name) \
    case name: \
        return #name;
        MCV_CL_ERRORS(MCV_X)
#undef MCV_X
    case NO_PLATFORM:
        return "CL_PLATFORM_NOT_FOUND_KHR";
    default:
        return "an unknown OpenCL error";
    }
}

/* Choosing a device */

/* The code of the first question that failed, or CL_SUCCESS. */
static cl_int describe(cl_platform_id platform, cl_device_id device, mcv_cl *cl) {
    char platform_name[100] = "";
    char device_name[150] = "";
    char device_version[120] = "";
    char driver[120] = "";
    cl_device_type type = 0;
    cl_device_fp_config single = 0;
    memset(cl, 0, sizeof *cl);
    cl->platform = platform;
    cl->device = device;
    const struct {
        cl_device_info what;
        size_t size;
        void *answer;
    } questions[] = {
        {CL_DEVICE_NAME, sizeof device_name, device_name},
        {CL_DEVICE_VERSION, sizeof device_version, device_version},
        {CL_DRIVER_VERSION, sizeof driver, driver},
        {CL_DEVICE_TYPE, sizeof type, &type},
        {CL_DEVICE_SINGLE_FP_CONFIG, sizeof single, &single},
        {CL_DEVICE_GLOBAL_MEM_SIZE, sizeof cl->memory, &cl->memory},
        {CL_DEVICE_MAX_MEM_ALLOC_SIZE, sizeof cl->largest_allocation, &cl->largest_allocation},
        {CL_DEVICE_MAX_COMPUTE_UNITS, sizeof cl->units, &cl->units}};
    cl_int code =
        clGetPlatformInfo(platform, CL_PLATFORM_NAME, sizeof platform_name, platform_name, NULL);
    for (size_t i = 0; i < sizeof questions / sizeof questions[0] && code == CL_SUCCESS; ++i)
        code = clGetDeviceInfo(device, questions[i].what, questions[i].size, questions[i].answer,
                               NULL);
    snprintf(cl->name, sizeof cl->name, "%s: %s", platform_name, device_name);
    snprintf(cl->version, sizeof cl->version, "%s, driver %s", device_version, driver);
    cl->cpu = (type & CL_DEVICE_TYPE_CPU) != 0;
    cl->correct_divide_sqrt = (single & CL_FP_CORRECTLY_ROUNDED_DIVIDE_SQRT) != 0;
    return code;
}

/* A sentence for the failure of all drivers; `code` is the last one's, or CL_SUCCESS. */
static mcv_result no_device(cl_int code, mcv_error *error) {
    struct rlimit space;
    if (code != CL_SUCCESS)
        return mcv_fail(
            error, MCV_DEVICE,
            "no OpenCL device can be used: the driver answered %s when it was asked for "
            "its devices; look for its messages, or start it anew",
            mcv_cl_error_name(code));
    if (getrlimit(RLIMIT_AS, &space) == 0 && space.rlim_cur != RLIM_INFINITY)
        return mcv_fail(error, MCV_DEVICE,
                        "no OpenCL driver could be loaded within the limit of the address space, "
                        "which is %.4g MB (ulimit -v): drivers need some GB of addresses, most of "
                        "it without memory; raise the limit, and bound the memory by --memory",
                        1e-6 * (double)space.rlim_cur);
    MCV_TRY(mcv_pocl_writes("no OpenCL device was found", error));
    return mcv_fail(error, MCV_DEVICE,
                    "no OpenCL device was found: install an OpenCL driver, such as Debian's "
                    "pocl-opencl-icd for the CPU");
}

mcv_result mcv_cl_list(void (*told)(void *user, unsigned index, const mcv_cl *device), void *user,
                       mcv_error *error) {
    cl_platform_id platforms[MAX_PLATFORMS];
    cl_uint platform_count = 0;
    MCV_TRY(mcv_pocl_check(error));
    cl_int failure = clGetPlatformIDs(MAX_PLATFORMS, platforms, &platform_count);
    if (failure != CL_SUCCESS) platform_count = 0;
    if (failure == NO_PLATFORM) failure = CL_SUCCESS;
    if (platform_count > MAX_PLATFORMS) platform_count = MAX_PLATFORMS;
    unsigned index = 0, described = 0;
    for (cl_uint p = 0; p < platform_count; ++p) {
        cl_device_id devices[MAX_DEVICES];
        cl_uint count = 0;
        cl_int code =
            clGetDeviceIDs(platforms[p], CL_DEVICE_TYPE_ALL, MAX_DEVICES, devices, &count);
        if (code != CL_SUCCESS) count = 0;
        if (code != CL_SUCCESS && code != CL_DEVICE_NOT_FOUND) failure = code;
        for (cl_uint d = 0; d < count && d < MAX_DEVICES; ++d, ++index) {
            mcv_cl cl;
            code = describe(platforms[p], devices[d], &cl);
            if (code != CL_SUCCESS) {
                failure = code; /* the other devices keep their numbers */
                continue;
            }
            told(user, index, &cl);
            ++described;
        }
    }
    return described > 0 ? MCV_OK : no_device(failure, error);
}

typedef struct choice {
    const char *wanted; /* NULL: the best */
    bool found;
    mcv_cl cl;
} choice;

static bool contains(const char *text, const char *part, size_t length) {
    if (length == 0) return true;
    for (; *text; ++text) {
        if (strncasecmp(text, part, length) == 0) return true;
    }
    return false;
}

/* Does a number or "PLATFORM:TYPE:NAME" name this device? */
static bool matches(const char *wanted, unsigned index, const mcv_cl *cl) {
    const char *first = strchr(wanted, ':');
    if (!first) {
        char *end;
        const unsigned long number = strtoul(wanted, &end, 10);
        return isdigit((unsigned char)wanted[0]) && *end == '\0' && number == index;
    }
    const char *second = strchr(first + 1, ':');
    const char *type = first + 1;
    const size_t type_length = second ? (size_t)(second - type) : strlen(type);
    const char *name = second ? second + 1 : "";
    const char *colon = strchr(cl->name, ':');
    char platform[sizeof cl->name];
    snprintf(platform, sizeof platform, "%.*s", (int)(colon - cl->name), cl->name);
    return contains(platform, wanted, (size_t)(first - wanted)) &&
           contains(cl->cpu ? "cpu" : "gpu", type, type_length) &&
           contains(colon, name, strlen(name));
}

static void choose(void *user, unsigned index, const mcv_cl *cl) {
    choice *c = user;
    const bool better = c->wanted ? !c->found && matches(c->wanted, index, cl)
                                  : !c->found || (c->cl.cpu && !cl->cpu);
    if (!better) return;
    c->found = true;
    c->cl = *cl;
}

/* Runs kernels/probe.cl, which every program holds, on numbers whose results IEEE 754 fixes to the
 * bit. */
static mcv_result probe(mcv_cl *cl, cl_program program, mcv_error *error) {
    static const float inputs[][3] = {{1.0f + 0x1p-12f, 1.0f + 0x1p-12f, -1.0f},
                                      {1.0f, 3.0f, 0.0f},
                                      {0x1p-126f, 0.25f, 0x1p-140f},
                                      {2.0f, 7.0f, 0x1p-30f},
                                      {10.0f, 9.0f, -90.0f},
                                      {1e20f, 3e-9f, -3e11f}};
    enum { CASES = sizeof inputs / sizeof inputs[0], RESULTS = 4 };
    float results[CASES][RESULTS];
    cl_kernel kernel = NULL;
    cl_mem in = NULL;
    cl_mem out = NULL;
    mcv_result result = mcv_cl_kernel(program, "probe_arithmetic", &kernel, error);
    if (result == MCV_OK)
        result = mcv_cl_buffer(cl, "the probe's numbers", sizeof inputs, inputs, &in, error);
    if (result == MCV_OK)
        result = mcv_cl_buffer(cl, "the probe's results", sizeof results, NULL, &out, error);
    if (result == MCV_OK)
        result = MCV_LAUNCH(cl, kernel, CASES, 1, error, MCV_ARG(in), MCV_ARG(out));
    if (result == MCV_OK) result = mcv_cl_read(cl, out, 0, sizeof results, results, error);
    for (size_t i = 0; result == MCV_OK && i < CASES; ++i) {
        static const char *const names[RESULTS] = {"fma", "division", "square root",
                                                   "a product with a denormal result"};
        const float a = inputs[i][0];
        const float b = inputs[i][1];
        const float c = inputs[i][2];
        const float expected[RESULTS] = {fmaf(a, b, c), a / b, sqrtf(a), a * b};
        for (size_t k = 0; k < RESULTS && result == MCV_OK; ++k) {
            if (memcmp(&expected[k], &results[i][k], sizeof(float)) == 0) continue;
            result = mcv_fail(error, MCV_DEVICE,
                              "%s computes %s as %a where IEEE 754 gives %a: choose another device "
                              "(mcvisi devices)",
                              cl->name, names[k], (double)results[i][k], (double)expected[k]);
        }
    }
    mcv_cl_release(&in);
    mcv_cl_release(&out);
    if (kernel) clReleaseKernel(kernel);
    cl->probed = result == MCV_OK;
    return result;
}

mcv_result mcv_cl_find(const char *which, mcv_cl *cl, mcv_error *error) {
    choice c = {.wanted = which ? which : getenv("MCVISI_OPENCL_DEVICE")};
    memset(cl, 0, sizeof *cl);
    MCV_TRY(mcv_cl_list(choose, &c, error));
    if (!c.found) {
        return mcv_fail(error, MCV_DEVICE,
                        "no OpenCL device matches \"%s\": `mcvisi devices` lists numbers and names",
                        c.wanted);
    }
    *cl = c.cl;
    return MCV_OK;
}

mcv_result mcv_cl_find_all(const char *which, mcv_cl devices[MCV_MOST_DEVICES], uint32_t *count,
                           mcv_error *error) {
    char list[1024], *rest = NULL;
    *count = 0;
    if (!which) which = getenv("MCVISI_OPENCL_DEVICE");
    if (!which || !strchr(which, ',')) {
        *count = 1;
        return mcv_cl_find(which, devices, error);
    }
    snprintf(list, sizeof list, "%s", which);
    for (char *name = strtok_r(list, ",", &rest); name; name = strtok_r(NULL, ",", &rest)) {
        if (*count == MCV_MOST_DEVICES)
            return mcv_fail(error, MCV_DEVICE, "\"%s\" names more than %d devices", which,
                            MCV_MOST_DEVICES);
        MCV_TRY(mcv_cl_find(name, devices + *count, error));
        for (uint32_t i = 0; i < *count; ++i)
            if (devices[i].device == devices[*count].device)
                return mcv_fail(error, MCV_DEVICE, "\"%s\" names %s twice: name each device once",
                                which, devices[i].name);
        ++*count;
    }
    return *count > 0 ? MCV_OK
                      : mcv_fail(error, MCV_DEVICE, "\"%s\" names no OpenCL device", which);
}

mcv_result mcv_cl_start(mcv_cl *cl, mcv_error *error) {
    cl_int code;
    cl->context = mcv_cached_context(cl->device, &code);
    MCV_TRY(mcv_cl_check(cl, code, "making a context", error));
    cl->queue = clCreateCommandQueue(cl->context, cl->device, CL_QUEUE_PROFILING_ENABLE, &code);
    const mcv_result result = mcv_cl_check(cl, code, "making a command queue", error);
    if (result != MCV_OK) mcv_cl_close(cl);
    return result;
}

mcv_result mcv_cl_open(const char *which, mcv_cl *cl, mcv_error *error) {
    MCV_TRY(mcv_cl_find(which, cl, error));
    return mcv_cl_start(cl, error);
}

void mcv_cl_close(mcv_cl *cl) {
    if (cl->queue) clReleaseCommandQueue(cl->queue);
    if (cl->context) clReleaseContext(cl->context);
    cl->queue = NULL;
    cl->context = NULL;
}

/* Programs */

static mcv_result build_failure(mcv_cl *cl, cl_program program, const char *name, cl_int code,
                                mcv_error *error) {
    size_t size = 0;
    if (strstr(cl->name, "Portable Computing Language"))
        MCV_TRY(mcv_pocl_writes("kernels cannot be compiled", error));
    clGetProgramBuildInfo(program, cl->device, CL_PROGRAM_BUILD_LOG, 0, NULL, &size);
    char *log = calloc(size + 1, 1);
    if (log) clGetProgramBuildInfo(program, cl->device, CL_PROGRAM_BUILD_LOG, size, log, NULL);
    mcv_fail(error, MCV_DEVICE, "clBuildProgram of %s.cl for %s failed with %s: %.*s", name,
             cl->name, mcv_cl_error_name(code), BUILD_LOG_SHOWN, log ? log : "");
    free(log);
    return MCV_DEVICE;
}

static mcv_result program_source(const char *name, char **from_files, const char **source,
                                 mcv_error *error) {
    const char *root = getenv("MCVISI_KERNEL_DIR");
    *from_files = NULL;
    if (root) {
        MCV_TRY(mcv_flatten(root, name, from_files, error));
        *source = *from_files;
        return MCV_OK;
    }
    for (size_t i = 0; i < mcv_program_count; ++i) {
        if (strcmp(mcv_programs[i].name, name) == 0) {
            *source = mcv_programs[i].source;
            return MCV_OK;
        }
    }
    return mcv_fail(error, MCV_DEVICE, "the library has no OpenCL program \"%s\"", name);
}

/* From the cache or by the compiler. */
static mcv_result make_program(mcv_cl *cl, const char *name, const char *source,
                               const char *options, cl_program *program, mcv_error *error) {
    cl_int code = CL_SUCCESS;
    if (mcv_cache_load(cl, source, options, program)) return MCV_OK;
    *program = clCreateProgramWithSource(cl->context, 1, &source, NULL, &code);
    if (code != CL_SUCCESS)
        return mcv_fail(error, MCV_DEVICE, "clCreateProgramWithSource of %s.cl failed with %s",
                        name, mcv_cl_error_name(code));
    code = clBuildProgram(*program, 1, &cl->device, options, NULL, NULL);
    if (code != CL_SUCCESS) return build_failure(cl, *program, name, code, error);
    mcv_cache_store(cl, source, options, *program);
    return MCV_OK;
}

mcv_result mcv_cl_build(mcv_cl *cl, const char *name, const char *options, cl_program *program,
                        mcv_error *error) {
    char all_options[MCV_MAX_BUILD_OPTIONS];
    char *from_files = NULL;
    const char *source = NULL;
    *program = NULL;
    MCV_TRY(program_source(name, &from_files, &source, error));
    const int length =
        snprintf(all_options, sizeof all_options, "-cl-std=CL1.2%s %s",
                 cl->correct_divide_sqrt ? " -cl-fp32-correctly-rounded-divide-sqrt" : "", options);
    mcv_result result = MCV_OK;
    if (length >= (int)sizeof all_options)
        result = mcv_fail(error, MCV_DEVICE, "%s.cl: the build options are too long", name);
    if (result == MCV_OK && !from_files)
        *program = mcv_cached_program(cl->context, source, all_options);
    const bool made = result == MCV_OK && !*program;
    if (made) result = make_program(cl, name, source, all_options, program, error);
    if (result == MCV_OK && !cl->probed) result = probe(cl, *program, error);
    if (result == MCV_OK && made && !from_files)
        mcv_keep_program(cl->context, source, all_options, *program);
    free(from_files);
    if (result != MCV_OK && *program) {
        clReleaseProgram(*program);
        *program = NULL;
    }
    return result;
}

mcv_result mcv_cl_kernel(cl_program program, const char *name, cl_kernel *kernel,
                         mcv_error *error) {
    cl_int code;
    *kernel = clCreateKernel(program, name, &code);
    if (code == CL_SUCCESS) return MCV_OK;
    *kernel = NULL;
    return mcv_fail(error, MCV_DEVICE, "clCreateKernel of %s failed with %s", name,
                    mcv_cl_error_name(code));
}
