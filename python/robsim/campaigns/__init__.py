"""Campaigns: many runs over seeds and options, on every core, with one call."""

from robsim._base.public import present as _present
from robsim.campaigns._campaign import campaign
from robsim.campaigns._result import CampaignResult
from robsim.campaigns._spec import CampaignSpec, Case
from robsim.campaigns._summary import CampaignSummary

__all__ = ["CampaignResult", "CampaignSpec", "CampaignSummary", "Case", "campaign"]

_present(globals())
