"""Valid and invalid requests that schemathesis makes from the page's OpenAPI description."""
import collections
import warnings

import hypothesis
import requests
import schemathesis
from hypothesis import HealthCheck, Phase
from hypothesis.strategies import sampled_from
from rig.processes.started import WAIT_S
from schemathesis import GenerationMode
from schemathesis.core.failures import Failure, FailureGroup
from schemathesis.specs.openapi import checks

DESCRIPTION = '/page/openapi.yaml'
AGREES = [checks.status_code_conformance, checks.content_type_conformance, checks.response_headers_conformance,
          checks.response_schema_conformance]
SETTINGS = dict(deadline=None, database=None, phases=[Phase.generate], suppress_health_check=list(HealthCheck))


def ask(port, seed, count, known):
    """Send ``count`` valid and ``count`` invalid requests to each address.

    ``known``: {parameter: [values that exist]}; some requests get one of these.

    Returns {(method, path, status): count}, and sentences about answers that do not match the description.
    """
    schema = schemathesis.openapi.from_url('http://127.0.0.1:%d%s' % (port, DESCRIPTION))
    answers, faults = collections.Counter(), []
    for found in schema.get_all_operations():
        operation = found.ok()
        for mode in GenerationMode.POSITIVE, GenerationMode.NEGATIVE:
            @hypothesis.seed(seed)
            @hypothesis.settings(max_examples=count, **SETTINGS)
            @hypothesis.given(case=operation.as_strategy(generation_mode=mode), value=sampled_from([None, *(
                (name, value) for name, values in known.items() for value in values)]))
            def asked(case, value):
                for part in case.query, case.path_parameters:
                    if value and value[0] in (part or {}):
                        part[value[0]] = value[1]
                try:
                    answer = answer_to(case, port)
                    answers[case.method, case.operation.path, answer.status_code] += 1
                    case.validate_response(answer, checks=AGREES)
                except (Failure, FailureGroup, requests.RequestException) as fault:
                    faults.append('%s %s %s: %s' % (case.method, case.formatted_path, case.query, fault))
            with warnings.catch_warnings():
                warnings.simplefilter('ignore')
                try:
                    asked()
                except hypothesis.errors.Unsatisfiable:
                    if mode == GenerationMode.POSITIVE:
                        raise
                    # else no request to this address can be invalid
    return answers, faults


def answer_to(case, port):
    """The requests.Response to a schemathesis Case. The body of a stream is not read, since it does not end."""
    request = case.as_transport_kwargs('http://127.0.0.1:%d' % port)
    with requests.request(stream=True, timeout=WAIT_S, **request) as answer:
        if 'multipart' in answer.headers.get('Content-Type', ''):
            answer._content, answer._content_consumed = b'', True
        else:
            len(answer.content)  # this reads the body
    return answer
