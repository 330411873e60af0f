"""Give the estimator the newest sample, and return the parameters, (3, 5)."""


def estimate_parameters(step):
    if step.sample is None:
        return None
    return step.estimator.update(step.sample.phi, step.sample.y)
